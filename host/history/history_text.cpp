// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "host/history/run_chart.hpp"
#include "host/history/summary.hpp"
#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

std::string plural(size_t count, const char* what) {
  return print("%zu %s%s", count, what, count == 1 ? "" : "s");
}

// Three significant digits; a column holds no more than four characters.
std::string index_number(double value) {
  const double size = std::abs(value);
  if (size >= 999.5) return value > 0 ? ">999" : "<-99";
  return print("%.*f", size >= 99.95 ? 0 : size >= 9.995 ? 1 : 2, value + 0.0);
}

std::string index_text(const std::optional<double>& value, const std::optional<Interval>& interval) {
  if (!value || !interval) return "-";
  return index_number(*value) + " [" + index_number(interval->low) + "," + index_number(interval->high) + "]";
}

std::string limits_text(const QuantityHistory& quantity) {
  if (quantity.lower && quantity.upper) return print("+-%.4g", *quantity.upper);
  return quantity.upper ? print("<=%.4g", *quantity.upper) : "-";
}

// In a column of 11, as the report has them.
std::string short_name(const QuantityHistory& quantity) {
  std::string name = quantity.name;
  for (const auto& [word, in_short] : {std::pair<std::string, const char*>{"perpendicularity", "square"},
                                       {"parallelism", "parallel"},
                                       {"angularity", "ang. mrad"}})
    if (name.starts_with(word)) name.replace(0, word.size(), in_short);
  return name;
}

std::string cut(const std::string& text, size_t columns) {
  return text.size() <= columns ? text : text.substr(0, columns - 3) + "...";
}

std::string statistics_line(int face, const QuantityHistory& quantity) {
  const Capability& c = quantity.capability;
  std::string line = print("%4d %-11.11s %4zu", face, short_name(quantity).c_str(), c.n);
  if (c.n == 0) return line + " no value\n";
  line += print(" %+8.4f %7.4f %+8.4f %+8.4f %8s", c.mean + 0.0, c.s, c.min + 0.0, c.max + 0.0,
                limits_text(quantity).c_str());
  if (!quantity.upper) return line + "  -\n";
  if (c.n < kFewestForCapability) return line + "  n too small\n";
  if (!c.cpk) return line + "  no spread\n";
  line +=
      print("  %-16s %s", index_text(c.cp, c.cp_interval).c_str(), index_text(c.cpk, c.cpk_interval).c_str());
  return line + "\n";
}

// What is limited; all when nothing is.
bool is_shown(const FaceHistory& face, const QuantityHistory& quantity, const HistoryTextOptions& options) {
  if (options.face != 0 || quantity.upper) return true;
  for (const QuantityHistory& other : face.quantities)
    if (other.upper) return false;
  return true;
}

// "rule 1: parts 8, 12; rule 4: part 20"
std::string signals_text(const ModelHistory& model, const QuantityHistory& quantity) {
  std::map<int, std::string> by_rule;
  for (const OutOfControl& signal : quantity.chart.signals) {
    std::string& list = by_rule[signal.rule];
    list +=
        (list.empty() ? "" : ", ") + std::to_string(model.parts[quantity.values[signal.index].part].number);
  }
  std::string text;
  for (const auto& [rule, list] : by_rule)
    text += (text.empty() ? "" : "; ") + print("rule %d: part", rule) + " " + list;
  return text;
}

std::string head(const ModelHistory& model) {
  std::map<std::string, size_t> verdicts;  // by verdict; those without a measurement on their own
  std::map<std::string, size_t> machines;
  for (const PartRecord& part : model.parts) {
    ++verdicts[part.reason.empty() ? std::string(verdict_name(part.verdict)) : "without a measurement"];
    if (part.faces.empty()) continue;
    ++machines[part.machine_id + (part.calibration_id.empty() ? "" : ", calibration " + part.calibration_id)];
  }
  std::string counts;
  for (const auto& [verdict, count] : verdicts) counts += print(", %zu ", count) + verdict;
  std::string text = wrapped("model " + cut(std::filesystem::path(model.model_name).filename(), 60) +
                             " (sha256 " + model.model_sha256.substr(0, 12) + "), held by " +
                             (model.held_by.empty() ? "-" : model.held_by));
  text += wrapped(plural(model.parts.size(), "part") + counts);
  for (const auto& [machine, count] : machines)
    if (machines.size() > 1) text += wrapped(plural(count, "part") + " by " + machine);
  return text;
}

std::string remarks(const ModelHistory& model, int only) {
  std::string text;
  for (const PartRecord& part : model.parts)
    if (!part.reason.empty() && only == 0)
      text += wrapped("part " + std::to_string(part.number) + " (" + part.part + "): " + part.reason);
  for (const FaceHistory& face : model.faces) {
    if (only != 0 && face.face != only) continue;
    std::string what;
    const auto add = [&](size_t count, const char* name) {
      if (count > 0) what += (what.empty() ? "" : ", ") + std::string(name) + print(" in %zu", count);
    };
    add(face.failed, "out of tolerance");
    add(face.undecided, "undecided");
    add(face.not_measured, "not measured");
    if (!what.empty()) text += wrapped(print("face %d: ", face.face) + what);
    for (const QuantityHistory& quantity : face.quantities) {
      if (quantity.unknown > 0)
        text += wrapped(print("face %d %s: left out in %zu, as a datum was not measured", face.face,
                              quantity.name.c_str(), quantity.unknown));
      if (quantity.limits_changed)
        text += wrapped(print("face %d %s: the limits have changed; those of the last part are used",
                              face.face, quantity.name.c_str()));
    }
  }
  return text;
}

std::string charts(const ModelHistory& model, const HistoryTextOptions& options) {
  std::string text;
  for (const FaceHistory& face : model.faces) {
    for (const QuantityHistory& quantity : face.quantities) {
      if (quantity.values.empty() || !is_shown(face, quantity, options)) continue;
      const std::string signals = signals_text(model, quantity);
      text += print("%4d %-11.11s ", face.face, short_name(quantity).c_str()) +
              run_chart_line(quantity, model.parts.size(), options) +
              (signals.empty() ? "" : print(" %zu out", quantity.chart.signals.size())) + "\n";
    }
  }
  if (text.empty()) return "";
  const std::string which = model.parts.size() > kChartColumns
                                ? print("the last %zu of %zu parts", kChartColumns, model.parts.size())
                                : "parts in their order";
  text = "run charts, " + which + "\n" + run_chart_legend(options) + text;
  std::string list;
  for (const FaceHistory& face : model.faces) {
    for (const QuantityHistory& quantity : face.quantities) {
      const std::string signals = signals_text(model, quantity);
      if (!signals.empty() && is_shown(face, quantity, options))
        list += wrapped(print("  face %d %s ", face.face, quantity.name.c_str()) + signals);
    }
  }
  if (list.empty()) return text;
  return text +
         wrapped(
             "out of control (Western Electric rules: 1 beyond 3 sigma, 2 two of three beyond 2 "
             "sigma, 3 four of five beyond 1 sigma, 4 eight in a row on one side):") +
         list;
}

// A line a part: value and U of each quantity, in the order of the face's history.
std::string values_table(const ModelHistory& model, const FaceHistory& face) {
  std::string text = "\n   no part             verdict     ";
  for (const QuantityHistory& quantity : face.quantities)
    text += print(" %10.10s +-U ", short_name(quantity).c_str());
  text += "\n";
  for (const PartRecord& part : model.parts) {
    const auto record = std::find_if(part.faces.begin(), part.faces.end(),
                                     [&](const FaceRecord& of) { return of.face == face.face; });
    if (record == part.faces.end()) continue;
    text += print("%5lld %-16.16s %-12s", static_cast<long long>(part.number), part.part.c_str(),
                  std::string(verdict_name(record->verdict)).c_str());
    for (const QuantityHistory& column : face.quantities) {
      const auto quantity = std::find_if(record->quantities.begin(), record->quantities.end(),
                                         [&](const Quantity& q) { return q.name == column.name; });
      text += quantity == record->quantities.end()
                  ? print(" %8s %6s", "-", "-")
                  : print(" %+8.4f %6.4f", quantity->value + 0.0, quantity->U);
    }
    text += "\n";
  }
  return text;
}

std::string one_face(const ModelHistory& model, const FaceHistory& face, const HistoryTextOptions& options) {
  std::string text = "\nrun charts: o a value, O out of control, X beyond a limit\n";
  for (const QuantityHistory& quantity : face.quantities) {
    if (quantity.values.empty()) continue;
    text += print("\nface %d (%s), %s, %s\n", face.face, face.type.c_str(), quantity.name.c_str(),
                  quantity.unit.c_str()) +
            run_chart_picture(quantity, model.parts.size(), options);
    const std::string signals = signals_text(model, quantity);
    if (!signals.empty()) text += wrapped("out of control: " + signals);
  }
  return text + values_table(model, face);
}

}  // namespace

std::string history_text(const ModelHistory& model, const HistoryTextOptions& options) {
  std::string text = head(model);
  std::string table;
  for (const FaceHistory& face : model.faces) {
    if (options.face != 0 && face.face != options.face) continue;
    for (const QuantityHistory& quantity : face.quantities)
      if (is_shown(face, quantity, options)) table += statistics_line(face.face, quantity);
  }
  if (!table.empty()) {
    text +=
        "\nface what           n     mean       s      min      max   limits  Cp [95 %]        Cpk [95 %]\n" +
        table;
  }
  if (const std::string said = remarks(model, options.face); !said.empty()) text += "\n" + said;
  if (options.face == 0) {
    if (const std::string drawn = charts(model, options); !drawn.empty()) text += "\n" + drawn;
    return text;
  }
  for (const FaceHistory& face : model.faces)
    if (face.face == options.face) text += one_face(model, face, options);
  return text;
}

std::string parts_table(const std::vector<PartRecord>& parts) {
  std::string text =
      "   no part                     verdict      faces: pass  fail  undecided  not measured\n";
  for (const PartRecord& part : parts) {
    text += print("%5lld %-24.24s ", static_cast<long long>(part.number), part.part.c_str());
    if (part.faces.empty()) {
      // The first line of it; `history` has all.
      text += print("%-60.60s\n", part.reason.substr(0, part.reason.find('\n')).c_str());
      continue;
    }
    std::map<Verdict, size_t> counts;
    for (const FaceRecord& face : part.faces) ++counts[face.verdict];
    text += print("%-12s %11zu %5zu %10zu %13zu\n", std::string(verdict_name(part.verdict)).c_str(),
                  counts[Verdict::pass], counts[Verdict::fail], counts[Verdict::undecided],
                  counts[Verdict::not_measured]);
  }
  return text;
}

}  // namespace tetragauge
