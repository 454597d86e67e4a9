#include "tremula/base/color.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/base/noise.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/dynamics/canopy_sway.hpp"
#include "tremula/geometry/texels.hpp"
#include "tremula/raytrace/volume_shape.hpp"
#include "tremula/scene/placing.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "scene_things.hpp"

namespace tremula::cli {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3f;

// What is known of a species. Of a plant of another height all lengths are as much larger, frequencies as
// much lower and static displacements larger by its square: the same wood under the same wind.
struct Species {
  std::string_view name;
  double texel_size;          // by default [m]
  double frequency, damping;  // [Hz], of critical
  double given;               // d of the mean wind's push: displacement of the tops is d U^2 [m/(m/s)^2]
  double neighbours;          // over which tops move together [m]
  int variants;
  double lower;  // plants are lower than the highest by up to this share, from place to place
  VolumeLook look;
};

// Rice: a canopy takes rho u*^2 from the wind, with u* about 0.3 of the wind over it 0.11 N/m^2 at 1 m/s; its
// 270 culms a square metre stand on 3 EI/l^3 each, with EI of 0.015 N m^2 (0.005 to 0.03, Ookawa), and are
// pushed two thirds up. Frequency and damping as alfalfa and wheat have them (1 to 2.5 Hz, 0.08: Py, de
// Langre and Moulia 2006). Hairs by the drag of a thin cylinder at a tenth of the wind, keratin of 4 GPa; the
// frequency is that of a hair of 0.1 mm that others hold up. Shoots of moss hardly move.
const Species all_species[] = {
    {"rice",
     0.015,
     1.0,
     0.09,
     4.4e-3,
     0.25,
     3,
     0.14,
     {.translucent = 0.45F, .roughness = 0.6F, .patches = 0.22F, .patch_size = 2.5F}},
    {"moss",
     0.0008,
     12,
     0.2,
     6e-6,
     0.01,
     3,
     0.5,
     {.translucent = 0.4F, .roughness = 0.6F, .patches = 0.35F, .patch_size = 0.05F}},
    {"fur",
     0.0009,
     6,
     0.25,
     2.5e-4,
     0.02,
     3,
     0.15,
     {.translucent = 0.25F, .roughness = 0.45F, .patches = 0.2F, .patch_size = 0.12F}},
};

const Species& species_of(std::string_view name) {
  return *std::ranges::find(all_species, name, &Species::name);
}

// The mean colour of the patch becomes this.
void color_strands(const Vector3f& srgb, StrandPatch& patch) {
  Vector3f wanted, sum = Vector3f::Zero();
  for (int i = 0; i < 3; ++i) wanted[i] = linear_from_srgb(srgb[i]);
  float area = 0;
  for (const Strand& strand : patch.strands) {
    const auto own = static_cast<float>(area_of(strand));
    sum += own * 0.5F * (strand.first_color + strand.last_color);
    area += own;
  }
  const Vector3f factor = wanted.cwiseQuotient((sum / area).cwiseMax(1e-4F));
  for (Strand& strand : patch.strands) {
    strand.first_color = strand.first_color.cwiseProduct(factor).cwiseMin(1.0F);
    strand.last_color = strand.last_color.cwiseProduct(factor).cwiseMin(1.0F);
  }
}

// The shape model: patches that may lie side by side, of plants of one species.
struct ShapeModel {
  std::vector<StrandPatch> patches;  // (variants)
  double height = 0;                 // of the highest point [m]
  double scale = 1;                  // of the species
};

ShapeModel grow_shape_model(const SceneVolume& volume, const Species& species) {
  const VolumePlant plant = volume_plant_of(volume.species);
  ShapeModel model;
  const auto natural = static_cast<double>(grow_strands(plant, {.seed = volume.seed}).height);
  model.scale = volume.height.value_or(natural) / natural;
  for (int i = 0; i < species.variants; ++i) {
    model.patches.push_back(grow_strands(plant, {.scale = model.scale, .seed = volume.seed, .variant = i}));
    model.height = std::max(model.height, static_cast<double>(model.patches.back().height));
    if (volume.color) color_strands(*volume.color, model.patches.back());
  }
  return model;
}

void check_room(const StrandPatch& patch, double texel_size, double height, int variants) {
  const double texels = texel_count(patch, texel_size, height);
  const double bytes = texels * (1.3 * sizeof(Texel) * variants + 12);  // while one more is made
  if (texels <= most_texels && bytes <= 0.5 * static_cast<double>(available_memory())) return;
  throw InputError(
      "texel_size",
      number_text(texel_size) + " m, which makes " + std::to_string(variants) + " textures of " +
          number_text(texels) + " texels",
      "fewer: at most " + number_text(most_texels) + " each, in half of the memory that is free");
}

std::vector<std::vector<Texels>> textures_of(const ShapeModel& model, const SceneVolume& volume,
                                             const Species& species) {
  const double texel_size = volume.texel_size.value_or(species.texel_size * model.scale);
  check_room(model.patches.front(), texel_size, model.height, species.variants);
  std::vector<std::vector<Texels>> textures;
  for (const StrandPatch& patch : model.patches)
    textures.push_back(
        mip_levels(scan_convert(patch, texel_size, model.height), static_cast<double>(patch.size.x()) / 6));
  return textures;
}

// A plant that is larger gives more and slower: it is made of the same.
CanopyResponse response_of(const Species& species, double scale) {
  CanopyResponse response;
  response.frequency = species.frequency / scale;
  response.damping_ratio = species.damping;
  response.give = species.given * scale * scale;
  response.neighbours = species.neighbours * scale;
  return response;
}

CanopySway sway_of(const SceneVolume& volume, const CanopyResponse& response, double height,
                   const ThingSite& site) {
  const double gust_height = std::max(height, 0.5);  // nearer to the ground the profile of the wind ends
  const double spacing = std::clamp((volume.high - volume.low).maxCoeff() / 64, 0.1, 1.0);
  const TravellingField gusts = site.gusts(volume.low, volume.high, spacing, {gust_height});
  return canopy_sway(gusts, response);
}

// Plants are lower here and there, and none stand where the masks say so.
std::function<double(const Vector2d&)> tallness_of(const SceneVolume& volume, double lower, double patch) {
  return [=](const Vector2d& place) {
    if (!masks_leave(volume.inside, volume.outside, place)) return 0.0;
    const Vector2f at = (place / (1.3 * patch)).cast<float>() + Vector2f::Constant(500);
    const float high = 0.6F * noise(at.x(), at.y(), 0, 81) + 0.4F * noise(3 * at.x(), 3 * at.y(), 0, 82);
    return 1 - lower * (1 - static_cast<double>(high));
  };
}

using Tallness = std::function<double(const Vector2d& place)>;

void check_place(const SceneVolume& volume, const Tallness& tallness) {
  Scatter masks;  // has the same masks, which are checked with it
  masks.low = volume.low;
  masks.high = volume.high;
  masks.inside = volume.inside;
  masks.outside = volume.outside;
  check_scatter(masks);
  constexpr int steps = 200;
  for (int i = 0; i < steps * steps; ++i) {
    const Vector2d share((i % steps + 0.5) / steps, (i / steps + 0.5) / steps);
    if (tallness(volume.low + share.cwiseProduct(volume.high - volume.low)) > 0) return;
  }
  throw InputError("inside, outside", "nothing of the field is left", "a place to grow in");
}

Tallness checked_tallness(const SceneVolume& volume, const Species& species, const ShapeModel& model) {
  const auto patch_size = static_cast<double>(model.patches.front().size.x());
  Tallness tallness = tallness_of(volume, species.lower, patch_size);
  check_place(volume, tallness);
  return tallness;
}

}  // namespace

GrownVolume grow_volume(const SceneVolume& volume, const ThingSite& site) {
  const Species& species = species_of(volume.species);
  const ShapeModel model = grow_shape_model(volume, species);
  auto field = std::make_shared<VolumeField>();
  field->low = volume.low;
  field->high = volume.high;
  field->ground = site.ground();
  field->seed = static_cast<std::uint32_t>(volume.seed);
  field->patches = textures_of(model, volume, species);
  field->tallness = checked_tallness(volume, species, model);
  field->height = static_cast<double>(field->patches.front().front().size().z());
  const auto sway = std::make_shared<const CanopySway>(
      sway_of(volume, response_of(species, model.scale), field->height, site));
  field->sway = [sway](const Vector2d& place, double time) { return (*sway)(place, time); };
  field->most_sway = sway->most;
  return {.field = std::move(field), .scale = model.scale, .strands = model.patches.back().strands.size()};
}

StrandField grow_strand_field(const SceneVolume& volume, const ThingSite& site) {
  const Species& species = species_of(volume.species);
  ShapeModel model = grow_shape_model(volume, species);
  StrandField field;
  field.height = model.height;
  field.low = volume.low;
  field.high = volume.high;
  field.tallness = checked_tallness(volume, species, model);
  field.sway = sway_of(volume, response_of(species, model.scale), model.height, site);
  field.translucent = species.look.translucent;
  field.seed = static_cast<std::uint32_t>(volume.seed);
  field.patches = std::move(model.patches);
  return field;
}

SceneThing make_volume(const SceneVolume& volume, const ThingSite& site) {
  const GrownVolume grown = grow_volume(volume, site);
  VolumeLook look = species_of(volume.species).look;
  look.patch_size *= static_cast<float>(grown.scale);
  const Camera camera = site.camera.camera(0);
  look.pixel = static_cast<float>(2 * camera.half_height / site.scene.picture.size.y());
  SceneThing thing{.name = volume.name, .kind = "volume", .count = grown.strands};
  thing.shapes.push_back(std::make_shared<const RayShape>(volume_shape(grown.field, look, volume.name)));
  return thing;
}

}  // namespace tremula::cli
