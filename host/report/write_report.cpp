// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <system_error>

#include "host/base/whole_file.hpp"
#include "host/report/deviation_ply.hpp"
#include "host/report/page/report_page.hpp"
#include "host/report/report.hpp"

namespace tetragauge {
namespace {

// Full colour at the widest limit; without tolerances at the deviation that 19 of 20 points keep to.
double colour_scale_mm(const Report& report) {
  double widest = 0;
  for (const Face& face : report.model.faces()) {
    const FaceTolerance tolerance = report.tolerances.of(face);
    if (tolerance.profile_mm) widest = std::max(widest, *tolerance.profile_mm / 2);
    if (tolerance.offset_mm) widest = std::max(widest, *tolerance.offset_mm);
  }
  if (widest > 0) return widest;
  const Inspection& inspection = report.run.inspection;
  std::vector<double> sizes;
  for (size_t i = 0; i < inspection.point_face.size(); ++i)
    if (inspection.point_face[i] > 0)
      sizes.push_back(std::abs(static_cast<double>(inspection.point_deviation_mm[i])));
  if (sizes.empty()) return 1;
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 19 / 20);
  std::nth_element(sizes.begin(), at, sizes.end());
  return std::max(1e-6, *at);
}

}  // namespace

Status write_report(const std::filesystem::path& folder, const Report& report) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return bad_input(folder.string() + ": the folder cannot be made (" + error.message() +
                     "); give another one with --out");
  const std::array contents{deviation_ply(report, colour_scale_mm(report)), faces_csv(report),
                            report_page(report), report_json(report).dump(2) + "\n", report_text(report)};
  for (size_t k = 0; k < contents.size(); ++k)
    if (Status status = write_whole_file(folder / kReportFiles[k], contents[k]); !status) return status;
  return Done{};
}

int exit_code(Verdict verdict) {
  switch (verdict) {
    case Verdict::fail:
      return 1;
    case Verdict::undecided:
    case Verdict::not_measured:
      return 5;
    case Verdict::pass:
    case Verdict::skipped:
    case Verdict::none:
      return 0;
  }
  return 70;
}

}  // namespace tetragauge
