// Node poses as text: one row per frame and node.
#pragma once

#include "tremula/deformation/loop.hpp"

#include <span>
#include <string>

namespace tremula {

// Columns frame,time_s,node,x,y,z,rx,ry,rz: displaced position [m] in the plant's own (recentred) coordinates
// and rotation vector [rad] of every node, of a tree roots first, then the ends of branches 0, 1, …. A root
// moves as the foot of the first branch that stands on it does on its spring. Frames are samples of the loop,
// 0 … M-1 (M is frame 0 again). Of several instances a column "instance" (from 0) says whose pose it is.
// Numbers are written so that reading gives back the same double. Throws InputError for a frame below 0 or
// above M.
std::string encode_pose_table(const Loop& loop, std::span<const int> frames);

}  // namespace tremula
