// Wind fields for ParaView: VTK ImageData (.vti).
#pragma once

#include "tremula/wind/field.hpp"

#include <string>

namespace tremula {

class AtomicFile;

struct VtiOptions {
  int first_step = 0;
  int step_count = 0;  // 0: to the end
};

// One frozen box of wind, carried along x with the mean speed: the step that passed the plane first is the
// furthest downwind. Point data "velocity" [m/s] (u v w), float32, appended raw; a tower is left out. Throws
// InputError for steps that the field does not have and for a field without mean speed.
void write_vti(const std::string& path, const WindField& field, const VtiOptions& options = {});
// Into a file that the caller commits.
void write_vti(AtomicFile& out, const WindField& field, const VtiOptions& options = {});

}  // namespace tremula
