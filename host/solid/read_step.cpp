// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/read_step.hpp"

#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Reader.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <algorithm>
#include <cctype>
#include <sstream>

#include "host/solid/check_step_numbers.hpp"

namespace tetragauge {
namespace {

// OpenCASCADE reports to standard output, which is for data.
void silence_messages() {
  Message::DefaultMessenger()->ChangePrinters().Clear();
}

// STEP unit names as people write them.
std::string common_name(std::string unit) {
  std::transform(unit.begin(), unit.end(), unit.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  if (unit == "millimetre" || unit == "millimeter") return "mm";
  if (unit == "centimetre" || unit == "centimeter") return "cm";
  if (unit == "metre" || unit == "meter") return "m";
  if (unit == "micrometre" || unit == "micrometer") return "um";
  return unit;
}

}  // namespace

Result<StepModel> read_step(const std::string& content, const std::string& file) {
  if (content.find("ISO-10303-21") == std::string::npos) {
    return bad_input(
        file + ": not a STEP file, 'ISO-10303-21' is missing; export the part as STEP AP203, AP214 or AP242");
  }
  if (content.find("END-ISO-10303-21") == std::string::npos) {
    return bad_input(file +
                     ": the STEP file ends early, 'END-ISO-10303-21' is missing; export or copy it again");
  }
  if (Status status = check_step_numbers(content, file); !status) return status.error();
  silence_messages();
  STEPControl_Reader reader;
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  std::istringstream stream(content);
  if (reader.ReadStream(file.c_str(), stream) != IFSelect_RetDone) {
    return bad_input(file + ": the STEP file cannot be parsed; export it again");
  }
  TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
  reader.FileUnits(lengths, angles, solid_angles);
  reader.TransferRoots();
  StepModel model;
  model.shape = reader.OneShape();
  if (!lengths.IsEmpty()) model.declared_unit = common_name(lengths.First().ToCString());
  return model;
}

}  // namespace tetragauge
