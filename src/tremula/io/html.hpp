// One self-contained page (.html) that plays a loop: the viewer of viewer/, which is compiled into this
// library, and the loop itself as glTF, packed by meshopt and gzip: on bones where it has some, else as morph
// targets with signed weights. It asks the network for nothing.
#pragma once

#include "tremula/io/gltf.hpp"

#include <string>

namespace tremula {

// False where the program was built without Node.js and npm; the functions below then throw Error saying so.
bool can_write_html();

// `morphs` in the form MorphForm::signed_weights. The same arguments give the same bytes. Throws Error as
// encode_glb() does, and when the page would be larger than browsers open.
std::string encode_html(const Surface& surface, const MorphTargets& morphs, const LoopFacts& facts);

// On bones (Loop::rig). Throws as encode_glb() does.
std::string encode_html(const Loop& loop, const Rig& rig);

// The same page around what else its viewer shows (grass_page.hpp): `data` as it reads it. Throws Error as
// the others do.
std::string encode_page(std::string data, const std::string& name);

// Throws Error, also when the file cannot be written, and then leaves none behind.
void write_html(const std::string& path, const Surface& surface, const MorphTargets& morphs,
                const LoopFacts& facts);

}  // namespace tremula
