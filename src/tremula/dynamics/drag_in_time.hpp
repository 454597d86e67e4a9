// The drag as it is, square and all, instant by instant: what its best linear fit leaves out.
//
// A fit gives loads that are Gaussian where the wind is. |U + u| (U + u) is not: its gusts pull harder than
// its lulls let go, so that peaks lie higher and the series leans to one side.
#pragma once

#include "tremula/dynamics/loads.hpp"
#include "tremula/dynamics/transfer.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/point_wind.hpp"

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class Drag {
  linear,     // its mean and its best linear fit to the gusts (LoadModel)
  quadratic,  // evaluated at every site and instant
};

// The drag on one site in a wind that blows with this velocity now, shelter taken off [N]. Throws nothing;
// LoadModel::paper has no such drag.
Vec3 drag_on(const Site& site, const Vec3& velocity, const LoadOptions& options);

// What the drag on all sites adds to their mean loads, as forces on the coordinates: a matrix (M/2+1 x c) of
// coefficients for every draw of the wind that the transfer function takes. shapes (rows x c), in the order
// of the coordinates. How the structure itself moves in the wind stays in the damping. The wind of a loop is
// held for as many points at a time as `memory` takes [bytes], one at least, and drawn anew for the next.
// Throws InputError for LoadModel::paper, and for sizes that do not agree.
std::vector<Eigen::MatrixXcd> drag_in_time(const Sites& sites, const Loads& loads, const LoadOptions& options,
                                           Eigen::Ref<const Eigen::MatrixXd> shapes,
                                           const BinTransfer& transfer, const TimeAxis& axis,
                                           const PointWind& wind,
                                           const std::function<void(double done)>& progress = {},
                                           double memory = 256e6);

}  // namespace tremula
