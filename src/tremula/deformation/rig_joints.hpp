// The choice of joints for fit_rig. Internal to the deformation.
#pragma once

#include "tremula/deformation/rig.hpp"
#include "tremula/deformation/rig_axes.hpp"

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace tremula::rig {

// How every place moves, at instants that between them show how far it goes. (P x T), T of a place together
struct PlacePoses {
  std::size_t instants = 0;
  std::vector<Eigen::Vector3f> position;
  std::vector<Eigen::Matrix3f> frame;

  Vec3 position_of(int place, std::size_t t) const {
    return position[index_of(place) * instants + t].cast<double>();
  }
  Mat3 frame_of(int place, std::size_t t) const {
    return frame[index_of(place) * instants + t].cast<double>();
  }
};

struct Segment;
struct Term {
  const Segment* segment;  // null: the root
  double weight;
};
// What moves a cross section: few segments, the one of the largest weight first.
struct Mix {
  std::array<Term, 4> terms{Term{nullptr, 1}};
  int count = 1;
  std::span<const Term> all() const { return {terms.data(), static_cast<std::size_t>(count)}; }
};

// The piece of an axis from one knot to the next: it turns the chord between them.
struct Segment {
  Vec3 rest = Vec3::Zero();   // the knot where its joint sits
  Vec3 chord = Vec3::Zero();  // from there to the next knot, at rest
  Mix hook = {};              // what moves the knot; the first of it is the parent, and if there are more the
                              // joint travels
  int from = -1, to = 0;      // places of the axis, by their order; -1: its start
  int low = -1, high = 0;     // between these and at this part of the way is its middle
  double part = 0;
  bool is_foot = false;          // no piece of an axis, but what a stem stands on where the ground gives way
  std::vector<JointFrame> at{};  // (T)
  int joint = -1;                // its number in the rig

  const Segment* parent() const { return hook.terms[0].segment; }
  bool travels() const { return is_foot || hook.count > 1; }
};

// How an axis is moved: by its own segments, none where it rides on what carries it.
struct AxisFit {
  Mix base;  // what moves the place that it starts from
  std::unique_ptr<Segment> foot;
  std::vector<Segment> segments;
};

// Of the section so far along the axis [m].
Mix mix_at(const Axis& axis, const AxisFit& fit, double way);

// What a mix does to a point at rest, given the frame of every segment (of null for the root).
template <class FrameOf>
BlendedFrame blend_of(const Mix& mix, const FrameOf& frame_of) {
  BlendedFrame sum;
  for (const Term& term : mix.all()) {
    const JointFrame& frame = frame_of(term.segment);
    const Vec3 rest = term.segment == nullptr ? Vec3::Zero() : term.segment->rest;
    sum.turn += term.weight * frame.turn;
    sum.shift += term.weight * (frame.position - frame.turn * rest);
  }
  return sum;
}

// Where a segment stands, given its knot and how places move at one instant.
using PoseOfPlace = std::function<PlacePose(int place)>;
JointFrame segment_frame(const Axis& axis, const Segment& segment, const Vec3& knot, const PoseOfPlace& pose);

// Of a skin that is carried whole, as a leaf is: so much of the mix as leaves it its area, to 1 % at all
// instants, and for the rest its heaviest segment alone.
Mix stiffened(const Mix& mix, std::size_t instants);

// Lets go of collars that bend themselves, by an angle or by a share of the tolerance [m].
void release_bent_collars(const PlacePoses& poses, double tolerance, Axes& axes);

// (axes) As few segments as keep every place, and what reaches from it, within the tolerance [m] of where it
// should be at all instants.
std::vector<AxisFit> fit_axes(const Places& places, const Axes& axes, const PlacePoses& poses,
                              double tolerance);

}  // namespace tremula::rig
