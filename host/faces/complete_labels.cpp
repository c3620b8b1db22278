// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/complete_labels.hpp"

#include <algorithm>

namespace tetragauge {
namespace {

constexpr size_t kCrumb = 4;  // vertices: fewer are no piece of surface

// Unlabelled vertices take the label that most of their neighbours have, if two at least have it.
void fill(const SurfaceGraph& graph, int rounds, std::vector<int32_t>& label) {
  std::vector<int32_t> around;
  for (int round = 0; round < rounds; ++round) {
    std::vector<int32_t> filled = label;
    for (uint32_t v = 0; v < graph.size(); ++v) {
      if (label[v] != kNoRegion) continue;
      around.clear();
      for (uint32_t n : graph.around(v)) {
        if (label[n] != kNoRegion) around.push_back(label[n]);
      }
      std::sort(around.begin(), around.end());
      size_t best = 1;
      for (size_t begin = 0, end = 0; begin < around.size(); begin = end) {
        while (end < around.size() && around[end] == around[begin]) ++end;
        if (end - begin > best) {
          best = end - begin;
          filled[v] = around[begin];
        }
      }
    }
    label = std::move(filled);
  }
}

// Pieces of a label: connected vertices of the same one.
std::vector<std::vector<uint32_t>> pieces_of(const SurfaceGraph& graph, const std::vector<int32_t>& label) {
  std::vector<std::vector<uint32_t>> pieces;
  std::vector<uint8_t> done(graph.size(), 0);
  for (uint32_t seed = 0; seed < graph.size(); ++seed) {
    if (done[seed] || graph.around(seed).empty()) continue;
    std::vector<uint32_t>& piece = pieces.emplace_back(1, seed);
    done[seed] = 1;
    for (size_t at = 0; at < piece.size(); ++at) {
      for (uint32_t n : graph.around(piece[at])) {
        if (done[n] || label[n] != label[seed]) continue;
        done[n] = 1;
        piece.push_back(n);
      }
    }
  }
  return pieces;
}

// What is left in crumbs, and vertices that only long edges join to others, go with the triangles at them.
void fill_crumbs(const Reconstruction& reconstruction, const std::vector<std::vector<uint32_t>>& pieces,
                 std::vector<int32_t>& label) {
  std::vector<uint8_t> wanting(label.size(), 1);
  for (const auto& piece : pieces) {
    if (label[piece.front()] == kNoRegion && piece.size() < kCrumb) continue;
    for (uint32_t v : piece) wanting[v] = 0;
  }
  std::vector<std::pair<uint32_t, int32_t>> votes;
  for (int round = 0; round < 2; ++round) {
    votes.clear();
    for (const SurfaceTriangle& t : reconstruction.surface) {
      for (uint32_t v : t.vertex) {
        if (!wanting[v] || label[v] != kNoRegion) continue;
        for (uint32_t w : t.vertex) {
          if (label[w] != kNoRegion) votes.emplace_back(v, label[w]);
        }
      }
    }
    std::sort(votes.begin(), votes.end());
    size_t best = 0;
    for (size_t begin = 0, end = 0; begin < votes.size(); begin = end) {
      if (begin == 0 || votes[begin].first != votes[begin - 1].first) best = 0;
      while (end < votes.size() && votes[end] == votes[begin]) ++end;
      if (end - begin <= best) continue;
      best = end - begin;
      label[votes[begin].first] = votes[begin].second;
    }
  }
}

}  // namespace

std::vector<int32_t> complete_labels(const Reconstruction& reconstruction, const SurfaceGraph& graph,
                                     const FittedFaces& fitted) {
  std::vector<int32_t> label = fitted.vertex_face;
  constexpr int kFar = 3;  // edges: wider gaps are surface of their own
  std::vector<size_t> largest(fitted.fits.size(), 0);
  const auto pieces = pieces_of(graph, label);
  for (const auto& piece : pieces) {
    const int32_t f = label[piece.front()];
    if (f != kNoRegion)
      largest[static_cast<size_t>(f)] = std::max(largest[static_cast<size_t>(f)], piece.size());
  }
  for (const auto& piece : pieces) {
    const int32_t f = label[piece.front()];
    if (f == kNoRegion || piece.size() >= kCrumb || piece.size() == largest[static_cast<size_t>(f)]) continue;
    for (uint32_t v : piece) label[v] = kNoRegion;
  }
  fill(graph, kFar, label);
  fill_crumbs(reconstruction, pieces_of(graph, label), label);
  auto next = static_cast<int32_t>(fitted.fits.size());
  for (const auto& piece : pieces_of(graph, label)) {
    if (label[piece.front()] != kNoRegion) continue;
    for (uint32_t v : piece) label[v] = next;
    ++next;
  }
  return label;
}

}  // namespace tetragauge
