#include "tremula/raytrace/posed_scene.hpp"

#include "tremula/base/color.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int most_steps = 16;  // of a shutter, that is long beside a loop's samples

PartLook look_of(const SurfacePart& part) {
  PartLook look;
  const SurfaceMaterial& material = part.material;
  for (int i = 0; i < 3; ++i) look.color[i] = linear_from_srgb(std::clamp(material.color[i], 0.0F, 1.0F));
  look.two_sided = material.two_sided;
  look.pieces = part.pieces;
  const bool leaf = material.name == "leaf" || material.name == "ribbon";
  if (material.name == "bark") {
    look.kind = PartLook::Kind::bark;
  } else if (leaf) {
    look.kind = PartLook::Kind::leaf;
  } else if (material.name == "blade") {
    look.kind = PartLook::Kind::blade;
  } else if (material.two_sided && material.name != "panel") {
    look.kind = PartLook::Kind::cloth;
  }
  if (leaf || material.name == "panel") look.gloss = std::make_shared<const Gloss>(material.roughness);
  return look;
}

void check_loop(const Loop& loop) {
  const std::string place = "loop '" + loop.facts.name + "'";
  if (!loop.rest || loop.rest->vertex_count() == 0)
    throw InputError(place, "no vertices", "a surface to draw");
  if (!loop.skin_at) throw InputError(place, "no skin_at", "a function that gives its poses");
  const Surface& rest = *loop.rest;
  const std::size_t vertices = rest.vertex_count();
  if (rest.normal.size() != vertices || rest.texture.size() != vertices) {
    throw InputError(place,
                     std::to_string(rest.normal.size()) + " normals and " +
                         std::to_string(rest.texture.size()) + " places in the texture",
                     std::to_string(vertices) + ", as many as vertices");
  }
  for (const SurfacePart& part : rest.parts) {
    if (part.triangles.size() % 3 != 0)
      throw InputError(place, std::to_string(part.triangles.size()) + " corners", "three a triangle");
    for (const std::uint32_t vertex : part.triangles) {
      if (vertex >= vertices)
        throw InputError(place, "a corner at vertex " + std::to_string(vertex),
                         "one below " + std::to_string(vertices));
    }
  }
  check_instances(loop.instances, loop.repeats);
}

void share_poses(LoopShape& shape, int most_poses) {
  const Loop& loop = *shape.loop;
  std::map<double, std::uint32_t> known;
  for (const Instance& copy : loop.instances) known.emplace(copy.time_shift, 0);
  const bool rounded = known.size() > index_of(most_poses);
  const double step = rounded ? loop.period / most_poses : 0;
  const auto key_of = [&](double shift) {
    if (!rounded) return shift;
    const double number = std::fmod(std::round(shift / step), most_poses);
    return number < 0 ? number + most_poses : number + 0.0;
  };
  known.clear();
  for (const Instance& copy : loop.instances) known.emplace(key_of(copy.time_shift), 0);
  for (auto& [key, number] : known) {
    number = static_cast<std::uint32_t>(shape.shifts.size());
    shape.shifts.push_back(rounded ? key * step : key);
  }
  shape.pose_of_copy.reserve(loop.instances.size());
  for (const Instance& copy : loop.instances) shape.pose_of_copy.push_back(known.at(key_of(copy.time_shift)));
}

Vector3f placed(const Instance& copy, const Vector3f& point) {
  return (copy.rotation() * (copy.scale * point.cast<double>()) + copy.position).cast<float>();
}

int steps_of(const Loop& loop, double shutter) {
  if (!(shutter > 0) || loop.sample_count() == 0) return 1;  // no sample: it never moves
  const double rate = loop.period > 0 ? loop.sample_count() / loop.period : 30;
  return 1 + static_cast<int>(std::clamp(std::ceil(shutter * rate - 1e-6), 1.0, most_steps - 1.0));
}

void check_embree(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw Error("Embree has no memory left for the scene");
  throw Error("Embree failed with error " + std::to_string(static_cast<int>(error)));
}

RTCRay to_embree(const Ray& ray, float farthest) {
  RTCRay to{};
  to.org_x = ray.origin.x(), to.org_y = ray.origin.y(), to.org_z = ray.origin.z();
  to.dir_x = ray.direction.x(), to.dir_y = ray.direction.y(), to.dir_z = ray.direction.z();
  to.tnear = 0, to.tfar = farthest;
  to.time = ray.time;
  to.mask = ~0U;
  return to;
}

// What goes with a ray, and what a shape gives back that Embree has no room for.
struct ShapeQuery {
  EmbreeContext context;  // the first: Embree knows the rest by it
  std::uint32_t random;
  RayShapeHit hit;
};

bool hits_shape(const void* shapes, unsigned number, const RTCRay& ray, std::uint32_t random,
                RayShapeHit& hit) {
  const PosedRayShape& shape = (*static_cast<const std::vector<PosedRayShape>*>(shapes))[number];
  const Vector3f origin(ray.org_x, ray.org_y, ray.org_z), direction(ray.dir_x, ray.dir_y, ray.dir_z);
  return shape.hit(origin, direction, ray.time, ray.tfar, hash(random ^ hash(number)), hit) &&
         hit.distance > ray.tnear && hit.distance <= ray.tfar;
}

void intersect_shape(const RTCIntersectFunctionNArguments* with) {
  if (with->valid[0] == 0) return;
  RTCRayHit& query = *reinterpret_cast<RTCRayHit*>(with->rayhit);  // rays come one by one
  ShapeQuery& own = *reinterpret_cast<ShapeQuery*>(with->context);
  RayShapeHit hit;
  if (!hits_shape(with->geometryUserPtr, with->primID, query.ray, own.random, hit)) return;
  own.hit = hit;
  query.ray.tfar = hit.distance;
  query.hit.u = query.hit.v = 0;
  query.hit.geomID = with->geomID;
  query.hit.primID = with->primID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

void shape_in_the_way(const RTCOccludedFunctionNArguments* with) {
  if (with->valid[0] == 0) return;
  RTCRay& ray = *reinterpret_cast<RTCRay*>(with->ray);
  const ShapeQuery& own = *reinterpret_cast<const ShapeQuery*>(with->context);
  RayShapeHit hit;
  if (hits_shape(with->geometryUserPtr, with->primID, ray, own.random, hit))
    ray.tfar = -std::numeric_limits<float>::infinity();
}

void bounds_of_shape(const RTCBoundsFunctionArguments* with) {
  const Eigen::AlignedBox3f& box =
      (*static_cast<const std::vector<PosedRayShape>*>(with->geometryUserPtr))[with->primID].bounds;
  RTCBounds& to = *with->bounds_o;
  to.lower_x = box.min().x(), to.lower_y = box.min().y(), to.lower_z = box.min().z();
  to.upper_x = box.max().x(), to.upper_y = box.max().y(), to.upper_z = box.max().z();
}

std::vector<PosedRayShape> pose_ray_shapes(const std::vector<std::shared_ptr<const RayShape>>& shapes,
                                           double time, double shutter) {
  std::vector<PosedRayShape> all;
  for (const std::shared_ptr<const RayShape>& shape : shapes) {
    for (PosedRayShape& posed : shape->pose(time, shutter)) {
      if (!posed.hit) throw InputError("shape '" + shape->name + "'", "no function `hit`", "one");
      if (posed.bounds.isEmpty() || !posed.bounds.min().allFinite() || !posed.bounds.max().allFinite())
        throw Error("the pose of '" + shape->name + "' has bounds that are empty or not finite");
      all.push_back(std::move(posed));
    }
  }
  return all;
}

}  // namespace

LoopShape shape_of(std::shared_ptr<const Loop> loop, int most_poses) {
  if (!loop) throw InputError("loops of the scene", "one that is not there", "loops");
  check_loop(*loop);
  LoopShape shape;
  shape.loop = std::move(loop);
  for (const SurfacePart& part : shape.loop->rest->parts) {
    shape.triangles.insert(shape.triangles.end(), part.triangles.begin(), part.triangles.end());
    shape.part_ends.push_back(static_cast<std::uint32_t>(shape.triangles.size() / 3));
    shape.parts.push_back(look_of(part));
  }
  share_poses(shape, most_poses);
  return shape;
}

EmbreeDevice make_device() {
  EmbreeDevice device(rtcNewDevice(nullptr));
  if (!device) {
    throw Error("Embree does not start on this machine: error " +
                std::to_string(static_cast<int>(rtcGetDeviceError(nullptr))));
  }
  return device;
}

PosedScene::PosedScene(RTCDevice device, const std::vector<const LoopShape*>& shapes,
                       const std::vector<std::shared_ptr<const RayShape>>& ray_shapes, double time,
                       double shutter, double path_count)
    : ray_shapes_(pose_ray_shapes(ray_shapes, time, shutter)) {
  for (const LoopShape* shape : shapes) {
    const std::size_t first = poses_.size();
    for (const double shift : shape->shifts) {
      Pose pose;
      pose.shape = shape;
      pose.shift = time + shift;
      pose.steps.resize(index_of(steps_of(*shape->loop, shutter)));
      poses_.push_back(std::move(pose));
    }
    std::vector<std::uint32_t> copies(shape->shifts.size(), 0);
    for (const std::uint32_t pose : shape->pose_of_copy) ++copies[pose];
    for (std::size_t i = 0; i < shape->pose_of_copy.size(); ++i) {
      const std::uint32_t pose = shape->pose_of_copy[i];
      if (copies[pose] == 1) poses_[first + pose].only_copy = &shape->loop->instances[i];
    }
  }
  const auto instant = [&](const Pose& pose, std::size_t step) {
    const std::size_t steps = pose.steps.size();
    if (steps < 2) return pose.shift;
    return pose.shift + shutter * (static_cast<double>(step) / static_cast<double>(steps - 1) - 0.5);
  };
  // Every pose at every instant is a task of its own.
  std::vector<std::pair<std::size_t, std::size_t>> tasks;
  for (std::size_t p = 0; p < poses_.size(); ++p) {
    for (std::size_t s = 0; s < poses_[p].steps.size(); ++s) tasks.emplace_back(p, s);
  }
  std::vector<std::vector<Vector3f>> last_normals(poses_.size());
  tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t t) {
    const auto [p, s] = tasks[t];
    Pose& pose = poses_[p];
    const Surface& rest = *pose.shape->loop->rest;
    SurfaceDelta moved = pose.shape->loop->skin_at(instant(pose, s));
    const std::size_t vertices = rest.vertex_count();
    const Eigen::Matrix3f turn =
        (pose.only_copy ? pose.only_copy->rotation() : Mat3::Identity()).cast<float>();
    if (moved.position.size() != vertices || moved.normal.size() != vertices)
      throw InputError("skin_at of '" + pose.shape->loop->facts.name + "'",
                       std::to_string(moved.position.size()) + " vertices", std::to_string(vertices));
    Vector3f sum = Vector3f::Zero();
    for (std::size_t i = 0; i < vertices; ++i) {
      moved.position[i] += rest.position[i];
      sum += moved.position[i];
      if (pose.only_copy) moved.position[i] = placed(*pose.only_copy, moved.position[i]);
      moved.normal[i] = turn * (moved.normal[i] + rest.normal[i]).normalized();
    }
    if (!sum.allFinite())
      throw Error("the pose of '" + pose.shape->loop->facts.name + "' has numbers that are not finite");
    moved.position.push_back(Vector3f::Zero());  // Embree reads 16 bytes of the last
    pose.steps[s] = std::move(moved.position);
    if (s == 0)
      pose.normals = std::move(moved.normal);
    else if (s + 1 == pose.steps.size())
      last_normals[p] = std::move(moved.normal);
  });
  for (std::size_t p = 0; p < poses_.size(); ++p) {
    for (std::size_t i = 0; i < last_normals[p].size(); ++i) poses_[p].normals[i] += last_normals[p][i];
  }
  // A better tree takes four times as long to build and is a seventh faster to ask.
  constexpr double worth = 4;  // paths a triangle
  double triangles = 0;
  for (const LoopShape* shape : shapes)
    triangles += static_cast<double>(shape->triangles.size() / 3 * shape->shifts.size());
  build(device, shapes, path_count > worth * triangles);
}

void PosedScene::build(RTCDevice device, const std::vector<const LoopShape*>& shapes, bool many_rays) {
  const auto new_scene = [&] {
    EmbreeScene scene(rtcNewScene(device));
    if (many_rays) rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_HIGH);
    return scene;
  };
  const auto mesh_of = [&](Pose& pose) {
    const RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const LoopShape& shape = *pose.shape;
    rtcSetGeometryTimeStepCount(mesh, static_cast<unsigned>(pose.steps.size()));
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, shape.triangles.data(), 0,
                               12, shape.triangles.size() / 3);
    for (std::size_t s = 0; s < pose.steps.size(); ++s) {
      rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, static_cast<unsigned>(s), RTC_FORMAT_FLOAT3,
                                 pose.steps[s].data(), 0, sizeof(Vector3f), pose.steps[s].size() - 1);
    }
    rtcCommitGeometry(mesh);
    return mesh;
  };
  tbb::parallel_for(std::size_t{0}, poses_.size(), [&](std::size_t p) {
    Pose& pose = poses_[p];
    if (pose.only_copy) return;
    pose.scene = new_scene();
    const RTCGeometry mesh = mesh_of(pose);
    rtcAttachGeometry(pose.scene.get(), mesh);
    rtcReleaseGeometry(mesh);
    rtcJoinCommitScene(pose.scene.get());
  });
  top_ = new_scene();
  std::size_t first = 0;
  for (const LoopShape* shape : shapes) {
    for (std::size_t i = 0; i < shape->pose_of_copy.size(); ++i) {
      Pose& pose = poses_[first + shape->pose_of_copy[i]];
      const Instance& at = shape->loop->instances[i];
      const Mat3 rotation = at.rotation();
      triangles_ += shape->triangles.size() / 3;
      RTCGeometry geometry = nullptr;
      if (pose.only_copy) {
        geometry = mesh_of(pose);
      } else {
        geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, pose.scene.get());
        rtcSetGeometryTimeStepCount(geometry, 1);
        Eigen::Matrix<float, 3, 4> transform;
        transform << (at.scale * rotation).cast<float>(), at.position.cast<float>();
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform.data());
        rtcCommitGeometry(geometry);
      }
      rtcAttachGeometryByID(top_.get(), geometry, static_cast<unsigned>(copies_.size()));
      rtcReleaseGeometry(geometry);
      if (pose.only_copy) {
        copies_.push_back({&pose});
      } else {
        copies_.push_back({&pose, at.position.cast<float>(), static_cast<float>(at.scale),
                           static_cast<float>(rotation(0, 0)), static_cast<float>(rotation(1, 0))});
      }
    }
    first += shape->shifts.size();
  }
  attach_ray_shapes(device);
  rtcJoinCommitScene(top_.get());
  check_embree(device);
}

void PosedScene::attach_ray_shapes(RTCDevice device) {
  if (ray_shapes_.empty()) return;
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(ray_shapes_.size()));
  rtcSetGeometryUserData(geometry, &ray_shapes_);
  rtcSetGeometryBoundsFunction(geometry, bounds_of_shape, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_shape);
  rtcSetGeometryOccludedFunction(geometry, shape_in_the_way);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(top_.get(), geometry, static_cast<unsigned>(copies_.size()));
  rtcReleaseGeometry(geometry);
}

Hit PosedScene::closest(const Ray& ray, float farthest) const {
  alignas(16) RTCRayHit query;
  query.ray = to_embree(ray, farthest);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  ShapeQuery own{};
  own.random = ray.random;
  find_closest(top_.get(), own.context, query);
  Hit hit;
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return hit;
  hit.copy = query.hit.instID[0] == RTC_INVALID_GEOMETRY_ID ? query.hit.geomID : query.hit.instID[0];
  hit.triangle = query.hit.primID;
  hit.distance = query.ray.tfar;
  hit.u = query.hit.u;
  hit.v = query.hit.v;
  hit.of_shape = hit.copy == copies_.size();
  if (hit.of_shape) hit.shape = own.hit;
  return hit;
}

bool PosedScene::blocked(const Ray& ray, float farthest) const {
  alignas(16) RTCRay query = to_embree(ray, farthest);
  ShapeQuery own{};
  own.random = ray.random;
  find_any(top_.get(), own.context, query);
  return query.tfar < 0;
}

Spot PosedScene::spot(const Ray& ray, const Hit& hit) const {
  const Copy& copy = copies_[hit.copy];
  const Pose& pose = *copy.pose;
  const LoopShape& shape = *pose.shape;
  const Surface& rest = *shape.loop->rest;
  const std::uint32_t* corner = &shape.triangles[3 * std::size_t{hit.triangle}];
  Vector3f corners[3], normals[3];
  const std::size_t segments = pose.steps.size() - 1;
  const float place = ray.time * static_cast<float>(segments);
  const std::size_t step = std::min(static_cast<std::size_t>(place), segments > 0 ? segments - 1 : 0);
  const float t = place - static_cast<float>(step);
  for (int i = 0; i < 3; ++i) {
    corners[i] = pose.steps[step][corner[i]];
    if (segments > 0) corners[i] += t * (pose.steps[step + 1][corner[i]] - corners[i]);
    normals[i] = pose.normals[corner[i]];
  }
  const float w = 1 - hit.u - hit.v;
  const auto blend = [&](const auto& values) {
    return (w * values[corner[0]] + hit.u * values[corner[1]] + hit.v * values[corner[2]]).eval();
  };
  Spot spot;
  spot.copy = hit.copy;
  const std::size_t part =
      index_of(std::upper_bound(shape.part_ends.begin(), shape.part_ends.end(), hit.triangle) -
               shape.part_ends.begin());
  spot.part = &shape.parts[part];
  const Pieces& pieces = spot.part->pieces;
  spot.piece = pieces.size > 0 ? (corner[0] - pieces.first_vertex) / pieces.size : 0;
  spot.uv = blend(rest.texture).cwiseMax(-1e6F).cwiseMin(1e6F);  // noise counts in int
  spot.uv_ab = rest.texture[corner[1]] - rest.texture[corner[0]];
  spot.uv_ac = rest.texture[corner[2]] - rest.texture[corner[0]];
  spot.ab = copy.scale * copy.turned(corners[1] - corners[0]);
  spot.ac = copy.scale * copy.turned(corners[2] - corners[0]);
  spot.plane = spot.ab.cross(spot.ac).normalized();
  Vector3f point = w * corners[0] + hit.u * corners[1] + hit.v * corners[2];
  spot.point = copy.scale * copy.turned(point) + copy.position;
  Vector3f normal = w * normals[0] + hit.u * normals[1] + hit.v * normals[2];
  const float length = normal.norm();
  spot.normal = length > 1e-6F ? copy.turned(normal / length) : spot.plane;
  // Onto the planes through the corners (Hanika, Hacking the shadow terminator, Ray Tracing Gems II, 2021).
  spot.lifted = spot.point;
  if (!spot.part->two_sided) {
    const float shares[3] = {w, hit.u, hit.v};
    Vector3f lift = Vector3f::Zero();
    for (int i = 0; i < 3; ++i) {
      const float size = normals[i].squaredNorm();
      const float below = (point - corners[i]).dot(normals[i]);
      if (below < 0 && size > 1e-12F) lift -= shares[i] * below / size * normals[i];
    }
    spot.lifted += copy.scale * copy.turned(lift);
  }
  return spot;
}

}  // namespace tremula
