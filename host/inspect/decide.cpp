// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/decide.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {
namespace {

int severity(Verdict verdict) {
  switch (verdict) {
    case Verdict::fail:
      return 4;
    case Verdict::undecided:
      return 3;
    case Verdict::not_measured:
      return 2;
    case Verdict::pass:
      return 1;
    case Verdict::skipped:
    case Verdict::none:
      return 0;
  }
  return 0;
}

}  // namespace

std::string_view verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "fail";
    case Verdict::undecided:
      return "undecided";
    case Verdict::not_measured:
      return "not_measured";
    case Verdict::skipped:
      return "skipped";
    case Verdict::none:
      return "none";
  }
  return "none";
}

std::string_view rule_name(Rule rule) {
  switch (rule) {
    case Rule::guarded:
      return "guarded";
    case Rule::iso14253:
      return "iso14253-1:2017";
    case Rule::simple:
      return "simple";
  }
  return "guarded";
}

Verdict decide(double deviation, double U, double limit, Rule rule) {
  double guard = 0;
  if (rule == Rule::guarded) guard = U;
  if (rule == Rule::iso14253) guard = 1.65 / 2 * U;
  const double size = std::abs(deviation);
  if (size + guard <= limit) return Verdict::pass;
  if (size - guard > limit) return Verdict::fail;
  return Verdict::undecided;
}

Verdict worse(Verdict a, Verdict b) {
  return severity(b) > severity(a) ? b : a;
}

Verdict judge_part(const Inspection& inspection, const Solid& model, const Tolerances& tolerances) {
  Verdict verdict = Verdict::none;
  bool any = false;
  for (size_t k = 0; k < inspection.faces.size(); ++k) {
    const Face& face = model.faces()[k];
    if (tolerances.skip.contains(face.id) || !has_tolerance(tolerances.of(face))) continue;
    any = true;
    verdict = worse(verdict, inspection.faces[k].verdict);
  }
  const bool surplus = std::any_of(inspection.extra_faces.begin(), inspection.extra_faces.end(),
                                   [](const ExtraFace& face) { return face.out_of_tolerance; });
  if (any && (surplus || !inspection.material_faults.empty())) verdict = Verdict::fail;
  return verdict;
}

}  // namespace tetragauge
