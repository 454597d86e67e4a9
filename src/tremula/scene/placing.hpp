// Where the copies of a scene's objects stand, and when.
#pragma once

#include "tremula/scene/scene.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace tremula {

// Of a whole scene.
inline constexpr std::int64_t most_instances = 10'000'000;

// How many copies the rules ask for: of a scatter as many as stood there if nothing were masked. 2^62 for
// more.
std::int64_t count_instances(const Crowd& crowd);

// Copies of one object after the other, each in the order of its rules: one by one, grids, scatters. The
// same for the same objects. `advection`: the mean wind that carries gusts
// [m/s]; 0: they go nowhere. `period` [s]: into which time shifts are wrapped; 0: a clip, in which there are
// none.
//
// A copy at x shows what the loop has x·U/|U|² earlier (Taylor 1938: gusts are carried along as they are).
// A scatter has as many copies as its density asks for on the area that the masks leave, in the mean, and as
// find room within 1000 tries each.
//
// Throws InputError for more than most_instances, with the number; for numbers that are not finite; for
// scales that are not above 0; and for a scatter that its distance leaves no room for (check_scatter).
std::vector<std::vector<Instance>> place_objects(std::span<const SceneObject> objects, const Vec3& advection,
                                                 double period);
std::vector<Instance> place_instances(const Crowd& crowd, const Vec3& advection, double period);

// Throws InputError for a field that ends before it begins, for polygons of fewer than three corners, without
// an area or that cross themselves, and for more copies than keep their distance: discs of that diameter that
// are laid down by chance cover at most 54.7 % (Feder 1980); 45 % are allowed.
void check_scatter(const Scatter& scatter);

// Whether a place is in one of the first, if there are any, and in none of the others.
bool masks_leave(std::span<const Polygon> inside, std::span<const Polygon> outside,
                 const Eigen::Vector2d& place);

// Which of so many motions a copy that is turned by `turn` [rad] shows: number k was made for a wind that
// blows towards the wind's heading - k 2 pi / headings, so that turned it blows at most half a step off the
// wind's.
int nearest_heading(double turn, int headings);

// The copies by that number: (headings) lists.
std::vector<std::vector<Instance>> split_by_heading(std::span<const Instance> instances, int headings);

}  // namespace tremula
