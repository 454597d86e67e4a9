// The errors the library throws. It never prints; the program that calls it does.
#pragma once

#include <stdexcept>
#include <string>

namespace tremula {

// Something could not be done although the request made sense (exit code 1 of the command line).
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The request or the input is wrong (exit code 2 of the command line). The message is one line that names the
// place, the value found and the value wanted: "oak.swc:12: radius is -0.01, wanted a number above 0".
struct InputError : Error {
  using Error::Error;

  // place: "FILE:LINE", "FILE: cylinder 3", "--damping-ratio"; found: what stands there; wanted: what should.
  InputError(const std::string& place, const std::string& found, const std::string& wanted)
      : Error(place + ": " + found + ", wanted " + wanted) {}
};

}  // namespace tremula
