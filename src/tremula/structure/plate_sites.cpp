#include "tremula/structure/plate_sites.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/quadrature.hpp"

#include <memory>

namespace tremula {

PlateSites lay_sites(const Sheet& sheet) {
  static const std::vector<QuadraturePoint> quadrature = gauss_legendre(2);
  const auto [across, up] = sheet.elements;
  const auto [width, height] = element_of(sheet);
  PlateSites result;
  result.points.resize(3, across * up);
  for (int j = 0; j < up; ++j) {
    for (int i = 0; i < across; ++i) {
      const int point = j * across + i;
      result.points.col(point) = sheet.position({width * (i + 0.5), height * (j + 0.5)});
      for (const QuadraturePoint& s : quadrature) {
        for (const QuadraturePoint& t : quadrature) {
          result.places.emplace_back(width * (i + s.position), height * (j + t.position));
          result.sites.push_back(
              {point, SiteKind::plate, sheet.normal(), s.weight * t.weight * width * height, 0, 0});
        }
      }
    }
  }
  return result;
}

Sites find_sites(std::span<const PlacedPanel> panels, Eigen::Index row_count) {
  const auto places = std::make_shared<std::vector<PanelPlace>>();
  Sites result;
  for (const PlacedPanel& panel : panels) {
    PlateSites own = lay_sites(panel.sheet);
    const Eigen::Index before = result.points.cols();
    result.points.conservativeResize(3, before + own.points.cols());
    result.points.rightCols(own.points.cols()) = own.points;
    for (Site& site : own.sites) {
      site.point += static_cast<int>(before);
      result.sites.push_back(site);
    }
    for (const Eigen::Vector2d& place : own.places) places->push_back(place_on(panel, place));
  }
  const auto told = [places, row_count](std::size_t first, std::size_t last,
                                        Eigen::Ref<const Eigen::MatrixXd> displacements, auto shape) {
    check_equal("rows of the displacements", displacements.rows(), row_count);
    Eigen::MatrixXd moved(3 * static_cast<Eigen::Index>(last - first), displacements.cols());
    for (std::size_t s = first; s < last; ++s) {
      const PanelPlace& place = (*places)[s];
      moved.middleRows<3>(3 * static_cast<Eigen::Index>(s - first)) =
          place.*shape * corner_displacements(place, displacements);
    }
    return moved;
  };
  result.motion = [told](std::size_t first, std::size_t last,
                         Eigen::Ref<const Eigen::MatrixXd> displacements) {
    return told(first, last, displacements, &PanelPlace::translation);
  };
  result.turning = [told](std::size_t first, std::size_t last,
                          Eigen::Ref<const Eigen::MatrixXd> displacements) {
    return told(first, last, displacements, &PanelPlace::rotation);
  };
  result.gather = [places, row_count](const Eigen::Matrix3Xd& forces) -> Eigen::VectorXd {
    check_equal("columns of the forces on the sites", forces.cols(),
                static_cast<Eigen::Index>(places->size()));
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(row_count);
    for (std::size_t s = 0; s < places->size(); ++s) {
      const PanelPlace& place = (*places)[s];
      const Eigen::Matrix<double, 24, 1> corners =
          place.translation.transpose() * forces.col(static_cast<Eigen::Index>(s));
      for (int corner = 0; corner < 4; ++corner) {
        const Eigen::Index row = place.rows[index_of(corner)];
        if (row >= 0) sum.segment<6>(row) += corners.segment<6>(6 * corner);
      }
    }
    return sum;
  };
  return result;
}

}  // namespace tremula
