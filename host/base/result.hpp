// SPDX-License-Identifier: GPL-3.0-or-later
// Errors at module edges: a function that can fail for reasons outside the program returns Result<T>.
// Exceptions do not cross modules. The message names the file and place, what is wrong, and what to do next.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace tetragauge {

// The value of each kind is the exit code of the command line.
enum class ErrorKind { usage = 2, bad_input = 3, machine = 4, undecided = 5, internal = 70 };

struct Error {
  ErrorKind kind = ErrorKind::internal;
  std::string message;
};

inline Error bad_input(std::string message) {
  return {ErrorKind::bad_input, std::move(message)};
}
inline Error usage_error(std::string message) {
  return {ErrorKind::usage, std::move(message)};
}
inline Error machine_error(std::string message) {
  return {ErrorKind::machine, std::move(message)};
}
inline Error undecided_error(std::string message) {
  return {ErrorKind::undecided, std::move(message)};
}
inline Error internal_error(std::string message) {
  return {ErrorKind::internal, std::move(message)};
}

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  explicit operator bool() const { return state_.index() == 0; }
  bool ok() const { return state_.index() == 0; }

  // Precondition: ok().
  T& value() & { return std::get<0>(state_); }
  const T& value() const& { return std::get<0>(state_); }
  T&& value() && { return std::get<0>(std::move(state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  // Precondition: !ok().
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

struct Done {};
using Status = Result<Done>;

}  // namespace tetragauge
