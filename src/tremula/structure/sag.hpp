// A plant drawn without its weight, as it stands when it has it.
#pragma once

#include "tremula/geometry/skeleton.hpp"
#include "tremula/structure/beam_tree.hpp"

namespace tremula {

// The skeleton bent by its own weight (StructureOptions::gravity): every branch where its ends come to rest,
// straight between them, leaves turned with the place that carries them. What is assembled of it is under
// that weight, and weight bends it no further. Throws as assemble_tree and find_equilibrium do.
Skeleton sagged(const Skeleton& unloaded, const StructureOptions& options);

}  // namespace tremula
