#include "tremula/scene/scene_keys.hpp"

#include "tremula/base/number_text.hpp"

#include <cmath>
#include <numbers>
#include <type_traits>

namespace tremula {
namespace {

constexpr double far = 1e6;  // [m]
constexpr double above_zero = 1e-9;
constexpr double longest = 1e5;  // [s]

template <class Owner>
void add_variation(std::vector<SceneKey<Owner>>& keys) {
  keys.push_back({.name = "scale",
                  .target = &Owner::scale,
                  .least = 1e-3,
                  .most = 1e3,
                  .meaning = "Size beside that of the source, or the smallest and the largest of them"});
  keys.push_back({.name = "turn",
                  .target = &Owner::turn,
                  .unit = "degrees",
                  .least = -360,
                  .most = 360,
                  .word = "random",
                  .meaning = "About the vertical, from +x towards +y: one for all, or two to draw between"});
  keys.push_back(
      {.name = "random_shift",
       .target = &Owner::random_shift,
       .unit = "s",
       .least = 0,
       .most = longest,
       .meaning = "Besides what `travelling_gusts` does, each is ahead or behind by up to so much"});
  keys.push_back({.name = "seed",
                  .target = &Owner::seed,
                  .meaning = "Of all that is drawn; another seed, other places"});
}

template <class Owner>
void add_field(std::vector<SceneKey<Owner>>& keys) {
  keys.push_back({.name = "low",
                  .target = &Owner::low,
                  .unit = "m",
                  .least = -far,
                  .most = far,
                  .needed = true,
                  .meaning = "The smallest x and y of the field"});
  keys.push_back({.name = "high",
                  .target = &Owner::high,
                  .unit = "m",
                  .least = -far,
                  .most = far,
                  .needed = true,
                  .meaning = "The largest x and y of the field"});
}

template <class Owner>
void add_masks(std::vector<SceneKey<Owner>>& keys) {
  keys.push_back({.name = "inside",
                  .target = &Owner::inside,
                  .unit = "m",
                  .least = -far,
                  .most = far,
                  .otherwise = "all of the field",
                  .meaning = "A polygon or a list of them, in one of which it grows"});
  keys.push_back({.name = "outside",
                  .target = &Owner::outside,
                  .unit = "m",
                  .least = -far,
                  .most = far,
                  .otherwise = "none",
                  .meaning = "A polygon or a list of them, in none of which it grows"});
}

template <class Owner>
SceneKey<Owner> name_key(std::string_view otherwise) {
  return {
      .name = "name", .target = &Owner::name, .otherwise = otherwise, .meaning = "For messages and reports"};
}

template <class Owner>
SceneKey<Owner> color_key(std::string_view name, std::optional<Eigen::Vector3f> Owner::*target) {
  return {.name = name,
          .target = target,
          .least = 0,
          .most = 1,
          .otherwise = "its own",
          .meaning = "Red, green and blue as a screen shows them (sRGB)"};
}

// What is looked up in the wind of the scene.
void add_things(SceneKeys& all) {
  all.grass = {"[[grass]]",
               "grass",
               "Blades that stand in an area, each in the wind of its place.",
               {name_key<SceneGrass>("that of the species"),
                {.name = "species",
                 .target = &SceneGrass::species,
                 .choices = {"lawn", "meadow", "wheat", "rice", "reed"},
                 .meaning = "What grows there"}}};
  add_field(all.grass.keys);
  add_masks(all.grass.keys);
  all.grass.keys.push_back({.name = "density",
                            .target = &SceneGrass::density,
                            .unit = "1/m^2",
                            .least = above_zero,
                            .most = 1e6,
                            .otherwise = "that of the species",
                            .meaning = "Blades or stems"});
  all.grass.keys.push_back({.name = "height",
                            .target = &SceneGrass::height,
                            .unit = "m",
                            .least = 1e-3,
                            .most = 20,
                            .otherwise = "that of the species",
                            .meaning = "Of blades on the average"});
  all.grass.keys.push_back(color_key("color", &SceneGrass::color));
  all.grass.keys.push_back(
      {.name = "seed", .target = &SceneGrass::seed, .meaning = "Another seed, other blades"});

  all.drift = {"[[drift]]",
               "drift",
               "What the wind carries: snow, rain, leaves, seeds.",
               {name_key<SceneDrift>("that of its kind"),
                {.name = "kind",
                 .target = &SceneDrift::kind,
                 .choices = {"snow", "rain", "leaves", "seeds"},
                 .meaning = "What drifts"},
                {.name = "low",
                 .target = &SceneDrift::low,
                 .unit = "m",
                 .least = -far,
                 .most = far,
                 .needed = true,
                 .meaning = "The smallest x, y and z of the box that it is seen in"},
                {.name = "high",
                 .target = &SceneDrift::high,
                 .unit = "m",
                 .least = -far,
                 .most = far,
                 .needed = true,
                 .meaning = "The largest"},
                {.name = "density",
                 .target = &SceneDrift::density,
                 .unit = "1/m^3",
                 .least = above_zero,
                 .most = 1e6,
                 .otherwise = "that of its kind",
                 .meaning = "How many there are"},
                {.name = "intensity",
                 .target = &SceneDrift::intensity,
                 .unit = "mm/h",
                 .least = 0.01,
                 .most = 500,
                 .otherwise = "what its density says",
                 .meaning = "Instead of a density: of rain, or of snow melted"},
                {.name = "source_low",
                 .target = &SceneDrift::source_low,
                 .unit = "m",
                 .least = -far,
                 .most = far,
                 .otherwise = "none: it comes in through the sides of its box",
                 .meaning = "The smallest x, y and z of a box, as of a crown, that lets it go"},
                {.name = "source_high",
                 .target = &SceneDrift::source_high,
                 .unit = "m",
                 .least = -far,
                 .most = far,
                 .otherwise = "none",
                 .meaning = "The largest"},
                {.name = "source_rate",
                 .target = &SceneDrift::source_rate,
                 .unit = "1/s",
                 .least = above_zero,
                 .most = 1e6,
                 .meaning = "How many that box lets go"},
                {.name = "matter_density",
                 .target = &SceneDrift::matter_density,
                 .unit = "kg/m^3",
                 .least = 0.01,
                 .most = 2000,
                 .otherwise = "that of its kind",
                 .meaning = "Of itself; heavier ones fall faster, and stone does not drift"},
                {.name = "fall_speed",
                 .target = &SceneDrift::fall_speed,
                 .unit = "m/s",
                 .least = 1e-3,
                 .most = 60,
                 .otherwise = "that of its kind",
                 .meaning = "In still air"},
                {.name = "size",
                 .target = &SceneDrift::size,
                 .unit = "m",
                 .least = 1e-5,
                 .most = 1,
                 .otherwise = "that of its kind",
                 .meaning = "From end to end"},
                color_key("color", &SceneDrift::color),
                {.name = "lie_time",
                 .target = &SceneDrift::lie_time,
                 .unit = "s",
                 .least = 0,
                 .most = longest,
                 .meaning = "How long it lies on the ground before it is gone"},
                {.name = "seed", .target = &SceneDrift::seed, .meaning = "Another seed, other places"}}};

  all.impression = {
      "[[impressions]]",
      "impressions",
      "Trees as an impressionist paints them: a trunk, and a crown of quadrics with a texture, for far "
      "forests. Copies stand as those of objects do: `[[impressions.instances]]`, `[[impressions.grid]]`, "
      "`[[impressions.scatter]]`.",
      {name_key<SceneImpression>("that of its shape"),
       {.name = "shape",
        .target = &SceneImpression::shape,
        .choices = {"round", "oak", "poplar", "pine", "bush"},
        .meaning = "Of the crown"},
       {.name = "height",
        .target = &SceneImpression::height,
        .unit = "m",
        .least = 0.01,
        .most = 200,
        .meaning = "Of the tree"},
       {.name = "width",
        .target = &SceneImpression::width,
        .unit = "m",
        .least = 0.01,
        .most = 200,
        .otherwise = "that of its shape",
        .meaning = "Of the crown"},
       {.name = "frequency",
        .target = &SceneImpression::frequency,
        .unit = "Hz",
        .least = 1e-3,
        .most = 100,
        .otherwise = "from its height",
        .meaning = "With which its trunk sways"},
       color_key("leaf_color", &SceneImpression::leaf_color),
       color_key("bark_color", &SceneImpression::bark_color),
       {.name = "seed", .target = &SceneImpression::seed, .meaning = "Another seed, other crowns"}}};

  all.volume = {"[[volumes]]",
                "volumes",
                "Plants as a three-dimensional texture, which is repeated over an area.",
                {name_key<SceneVolume>("that of the species"),
                 {.name = "species",
                  .target = &SceneVolume::species,
                  .choices = {"rice", "moss", "fur"},
                  .meaning = "What grows there"}}};
  add_field(all.volume.keys);
  add_masks(all.volume.keys);
  all.volume.keys.push_back({.name = "height",
                             .target = &SceneVolume::height,
                             .unit = "m",
                             .least = 1e-3,
                             .most = 10,
                             .otherwise = "that of the species",
                             .meaning = "From the ground to the top"});
  all.volume.keys.push_back({.name = "texel_size",
                             .target = &SceneVolume::texel_size,
                             .unit = "m",
                             .least = 1e-5,
                             .most = 1,
                             .otherwise = "that of the species",
                             .meaning = "Edge of a cell of the texture"});
  all.volume.keys.push_back(color_key("color", &SceneVolume::color));
  all.volume.keys.push_back(
      {.name = "seed", .target = &SceneVolume::seed, .meaning = "Another seed, other plants"});

  all.gusts = {"[gusts]", "gusts", "The wind itself, to be seen.", {}};
  add_field(all.gusts.keys);
  all.gusts.keys.insert(
      all.gusts.keys.end(),
      {{.name = "height",
        .target = &SceneGusts::height,
        .unit = "m",
        .least = 0.01,
        .most = 1000,
        .meaning = "Above the ground"},
       {.name = "spacing",
        .target = &SceneGusts::spacing,
        .unit = "m",
        .least = 0.01,
        .most = 1000,
        .meaning = "From arrow to arrow"},
       {.name = "scale",
        .target = &SceneGusts::scale,
        .unit = "s",
        .least = 1e-4,
        .most = 1000,
        .meaning = "Length of an arrow for 1 m/s"},
       {.name = "arrows", .target = &SceneGusts::arrows, .meaning = "Show arrows"},
       {.name = "tint", .target = &SceneGusts::tint, .meaning = "Colour the ground by the speed"}});
}

SceneKeys all_keys() {
  SceneKeys all;
  all.scene = {
      "",
      "scene",
      "Before the first header.",
      {{.name = "name", .target = &Scene::name, .otherwise = "that of the file", .meaning = "For titles"}}};

  all.ground = {"[ground]",
                "ground",
                "What everything stands on, as far as the eye reaches.",
                {{.name = "kind",
                  .target = &SceneGround::kind,
                  .choices = {"grass", "soil", "sand", "snow", "plain", "none"},
                  .meaning = "What it looks like"},
                 {.name = "color",
                  .target = &SceneGround::color,
                  .least = 0,
                  .most = 1,
                  .meaning = "Of a plain one: the share of red, green and blue light that it sends back"},
                 {.name = "height",
                  .target = &SceneGround::height,
                  .unit = "m",
                  .least = -far,
                  .most = far,
                  .meaning = "Where it is"},
                 {.name = "grass_height",
                  .target = &SceneGround::grass_height,
                  .unit = "m",
                  .least = 0,
                  .most = 1,
                  .meaning = "Of grass, which stands in blades near the camera; 0: a pattern alone"}}};

  all.sky = {"[sky]",
             "sky",
             "What gives light.",
             {{.name = "sun_elevation",
               .target = &SceneSky::sun_elevation,
               .unit = "degrees",
               .least = 0,
               .most = 90,
               .meaning = "Of the sun above the horizon"},
              {.name = "sun_azimuth",
               .target = &SceneSky::sun_azimuth,
               .unit = "degrees",
               .least = -360,
               .most = 360,
               .meaning = "Where the sun stands, from +x towards +y"},
              {.name = "turbidity",
               .target = &SceneSky::turbidity,
               .least = 1,
               .most = 10,
               .meaning = "Of the air: 2 very clear, 3 clear, 6 hazy, 10 dull"},
              {.name = "uniform",
               .target = &SceneSky::uniform,
               .least = 0,
               .most = 1e6,
               .otherwise = "sun and sky",
               .meaning = "Instead of them the same radiance from everywhere"}}};

  all.medium = {"[medium]",
                "medium",
                "What is between things.",
                {{.name = "kind",
                  .target = &SceneMedium::kind,
                  .choices = {"auto", "air", "water"},
                  .meaning = "auto: water where all objects live in it"},
                 {.name = "visibility",
                  .target = &SceneMedium::visibility,
                  .unit = "m",
                  .least = 0.1,
                  .otherwise = "20000 in air, 12 in water",
                  .meaning = "How far a dark thing is seen"}}};

  all.camera = {"[camera]",
                "camera",
                "Who looks: along a path where there is one, else from `eye`, else from where all objects "
                "are in the frame.",
                {{.name = "frame",
                  .target = &SceneCamera::frame,
                  .word = "all",
                  .otherwise = "\"all\"",
                  .meaning = "Names of the objects that shall be in the frame"},
                 {.name = "azimuth",
                  .target = &SceneCamera::azimuth,
                  .unit = "degrees",
                  .least = -360,
                  .most = 360,
                  .otherwise = "across the wind",
                  .meaning = "Where to stand for that, as seen from the objects, from +x towards +y"},
                 {.name = "elevation",
                  .target = &SceneCamera::elevation,
                  .unit = "degrees",
                  .least = -85,
                  .most = 85,
                  .meaning = "From how far above the horizon to look down then"},
                 {.name = "margin",
                  .target = &SceneCamera::margin,
                  .least = 0,
                  .most = 0.45,
                  .meaning = "To leave then on each side, of the picture"},
                 {.name = "eye",
                  .target = &SceneCamera::eye,
                  .unit = "m",
                  .least = -far,
                  .most = far,
                  .meaning = "Where the camera stands"},
                 {.name = "look_at",
                  .target = &SceneCamera::look_at,
                  .unit = "m",
                  .least = -far,
                  .most = far,
                  .meaning = "What it looks at from there"},
                 {.name = "field_of_view",
                  .target = &SceneCamera::field_of_view,
                  .unit = "degrees",
                  .least = 0.1,
                  .most = 150,
                  .meaning = "From the bottom to the top of the picture"},
                 {.name = "aperture",
                  .target = &SceneCamera::aperture,
                  .unit = "m",
                  .least = 0,
                  .most = 10,
                  .meaning = "Diameter of the lens; 0: everything is sharp"},
                 {.name = "focus_distance",
                  .target = &SceneCamera::focus_distance,
                  .unit = "m",
                  .least = 1e-3,
                  .most = far,
                  .otherwise = "to what it looks at",
                  .meaning = "How far away things are sharp"},
                 {.name = "focus_at",
                  .target = &SceneCamera::focus_at,
                  .unit = "m",
                  .least = -far,
                  .most = far,
                  .meaning = "or a point that is sharp"},
                 {.name = "path_repeats",
                  .target = &SceneCamera::path_repeats,
                  .meaning = "The path closes with the loop; false: the camera rests before its beginning "
                             "and after its end"}}};

  all.path = {"[[camera.path]]",
              "camera.path",
              "A key of the camera's path, two or more, by time. Between keys it goes smoothly, never lower "
              "than both.",
              {{.name = "time",
                .target = &CameraKey::time,
                .unit = "s",
                .least = 0,
                .most = longest,
                .needed = true,
                .meaning = "When; before the end of the loop where the path repeats"},
               {.name = "eye",
                .target = &CameraKey::eye,
                .unit = "m",
                .least = -far,
                .most = far,
                .needed = true,
                .meaning = "Where the camera is then"},
               {.name = "look_at",
                .target = &CameraKey::look_at,
                .unit = "m",
                .least = -far,
                .most = far,
                .needed = true,
                .meaning = "What it looks at"},
               {.name = "field_of_view",
                .target = &CameraKey::field_of_view,
                .unit = "degrees",
                .least = 0.1,
                .most = 150,
                .otherwise = "that of [camera]",
                .meaning = "From the bottom to the top of the picture"}}};

  all.picture = {"[picture]",
                 "picture",
                 "How the picture is taken.",
                 {{.name = "size",
                   .target = &ScenePicture::size,
                   .unit = "pixels",
                   .least = 1,
                   .most = 16384,
                   .meaning = "Width and height, also as \"960x540\""},
                  {.name = "samples",
                   .target = &ScenePicture::samples,
                   .least = 1,
                   .most = 65536,
                   .meaning = "A pixel: four times as many, half the noise"},
                  {.name = "bounces",
                   .target = &ScenePicture::bounces,
                   .least = 0,
                   .most = 64,
                   .meaning = "Of light from thing to thing"},
                  {.name = "shutter",
                   .target = &ScenePicture::shutter,
                   .least = 0,
                   .most = 1,
                   .meaning = "How long it is open, of the time of a frame; 0: what moves is sharp"},
                  {.name = "exposure",
                   .target = &ScenePicture::exposure,
                   .unit = "stops",
                   .least = -40,
                   .most = 40,
                   .meaning = "Brighter than the light of the day asks for: 1 is twice as bright"},
                  {.name = "denoise",
                   .target = &ScenePicture::denoise,
                   .meaning = "Smooth what noise the samples leave"},
                  {.name = "seed", .target = &ScenePicture::seed, .meaning = "Of the samples"}}};

  all.object = {
      "[[objects]]",
      "objects",
      "Something that moves, one or more.",
      {{.name = "source",
        .target = &SceneObject::source,
        .needed = true,
        .meaning =
            "A file beside the scene's, of any form that `tremula animate` takes, or the name of a preset"},
       {.name = "name",
        .target = &SceneObject::name,
        .otherwise = "that of the source",
        .meaning = "For `frame` and for messages"},
       {.name = "growth_seed",
        .target = &SceneObject::growth_seed,
        .otherwise = "that of its text",
        .meaning = "Of a plant that is grown: another seed, another plant"},
       {.name = "set",
        .target = &SceneObject::constants,
        .meaning = "Other values for constants of its text: [\"nodes=20\"]"},
       {.name = "bark_color",
        .target = &SceneObject::bark_color,
        .least = 0,
        .most = 1,
        .otherwise = "that of the source",
        .meaning = "Red, green and blue as a screen shows them (sRGB)"},
       {.name = "leaf_color",
        .target = &SceneObject::leaf_color,
        .least = 0,
        .most = 1,
        .otherwise = "that of the source",
        .meaning = "likewise"},
       {.name = "color",
        .target = &SceneObject::color,
        .least = 0,
        .most = 1,
        .otherwise = "that of the source",
        .meaning = "likewise, of a sheet or of plates"},
       {.name = "headings",
        .target = &SceneObject::headings,
        .least = 1,
        .most = 64,
        .meaning = "Turned copies bow downwind in motions made for so many headings, the nearest for each"},
       {.name = "own_gusts",
        .target = &SceneObject::own_gusts,
        .least = 0,
        .most = 1000,
        .meaning = "Up to so many copies each move in the gusts of their own place; more share those of one "
                   "place, each at its own time"}}};
  all.crowd = {"",
               "objects",
               "",
               {{.name = "travelling_gusts",
                 .target = &Crowd::travelling_gusts,
                 .meaning = "What stands downwind moves as much later as the wind takes to get there"}}};

  all.instance = {"[[objects.instances]]",
                  "objects.instances",
                  "A copy of the object above it.",
                  {{.name = "position",
                    .target = &Instance::position,
                    .unit = "m",
                    .least = -far,
                    .most = far,
                    .on_ground = true,
                    .meaning = "Where its origin stands; two numbers: on the ground"},
                   {.name = "turn",
                    .target = &Instance::turn,
                    .unit = "degrees",
                    .least = -360,
                    .most = 360,
                    .meaning = "About the vertical, from +x towards +y"},
                   {.name = "scale",
                    .target = &Instance::scale,
                    .least = 1e-3,
                    .most = 1e3,
                    .meaning = "Size beside that of the source"},
                   {.name = "time_shift",
                    .target = &Instance::time_shift,
                    .unit = "s",
                    .least = -longest,
                    .most = longest,
                    .meaning = "How far ahead it is, besides what `travelling_gusts` does"}}};

  all.grid = {"[[objects.grid]]",
              "objects.grid",
              "Copies of the object above it in columns and rows.",
              {{.name = "columns",
                .target = &Grid::columns,
                .least = 1,
                .most = 1e6,
                .needed = true,
                .meaning = "How many along x"},
               {.name = "rows",
                .target = &Grid::rows,
                .least = 1,
                .most = 1e6,
                .needed = true,
                .meaning = "How many along y"},
               {.name = "spacing",
                .target = &Grid::spacing,
                .unit = "m",
                .least = above_zero,
                .most = far,
                .meaning = "From one to the next; or along x and y"},
               {.name = "centre",
                .target = &Grid::centre,
                .unit = "m",
                .least = -far,
                .most = far,
                .on_ground = true,
                .meaning = "Of the whole; two numbers: on the ground"},
               {.name = "jitter",
                .target = &Grid::jitter,
                .least = 0,
                .most = 1,
                .meaning = "How far off its place a copy is at most, along x and y, in spacings"}}};
  add_variation(all.grid.keys);

  all.scatter = {
      "[[objects.scatter]]",
      "objects.scatter",
      "Copies of the object above it here and there.",
      {{.name = "density",
        .target = &Scatter::density,
        .unit = "1/m^2",
        .least = 1e-12,
        .most = 1e6,
        .needed = true,
        .meaning = "How many on average"},
       {.name = "low",
        .target = &Scatter::low,
        .unit = "m",
        .least = -far,
        .most = far,
        .needed = true,
        .meaning = "Where the field begins, along x and y"},
       {.name = "high",
        .target = &Scatter::high,
        .unit = "m",
        .least = -far,
        .most = far,
        .needed = true,
        .meaning = "and where it ends"},
       {.name = "distance",
        .target = &Scatter::distance,
        .unit = "m",
        .least = 0,
        .most = far,
        .meaning = "That they keep from each other and from all copies placed before, of any object"},
       {.name = "inside",
        .target = &Scatter::inside,
        .unit = "m",
        .least = -far,
        .most = far,
        .otherwise = "the field",
        .meaning = "Polygons [[x, y], …]: there are copies in them only"},
       {.name = "outside",
        .target = &Scatter::outside,
        .unit = "m",
        .least = -far,
        .most = far,
        .meaning = "Polygons without copies"}}};
  add_variation(all.scatter.keys);
  add_things(all);
  return all;
}

// ---- In words

template <class Owner, class Value>
std::string kind_words(const SceneKey<Owner>& key, Value Owner::*) {
  std::string words;
  if constexpr (std::is_same_v<Value, int> || std::is_same_v<Value, std::uint64_t> ||
                std::is_same_v<Value, std::optional<std::uint64_t>>) {
    words = "a whole number";
  } else if constexpr (std::is_same_v<Value, bool>) {
    words = "true or false";
  } else if constexpr (std::is_same_v<Value, std::string>) {
    words = "a text";
    for (const std::string& choice : key.choices)
      words = (words == "a text" ? "one of " : words + ", ") + choice;
  } else if constexpr (std::is_same_v<Value, Vec3> || std::is_same_v<Value, std::optional<Vec3>>) {
    words = key.on_ground ? "two or three numbers" : "three numbers";
  } else if constexpr (std::is_same_v<Value, Eigen::Vector3f> ||
                       std::is_same_v<Value, std::optional<Eigen::Vector3f>>) {
    words = "three numbers";
  } else if constexpr (std::is_same_v<Value, Eigen::Vector2d>) {
    words = key.needed ? "two numbers" : "a number or two";
  } else if constexpr (std::is_same_v<Value, Eigen::Vector2i>) {
    words = "two whole numbers";
  } else if constexpr (std::is_same_v<Value, std::vector<Polygon>>) {
    words = "a list of polygons";
  } else if constexpr (std::is_same_v<Value, std::vector<std::string>>) {
    words = "a list of texts";
  } else {
    words = "a number";
  }
  return words;
}

template <class Owner>
std::string range_words(const SceneKey<Owner>& key) {
  if (std::abs(key.least) >= far && key.most >= far) return "";
  if (key.least > 0 && key.least <= above_zero) return "above 0";
  if (key.most >= far) return "of " + number_text(key.least) + " or more";
  return "from " + number_text(key.least) + " to " + number_text(key.most);
}

std::string value_words(double value) { return number_text(value); }
std::string value_words(int value) { return std::to_string(value); }
std::string value_words(std::uint64_t value) { return std::to_string(value); }
std::string value_words(bool value) { return value ? "true" : "false"; }
std::string value_words(const std::string& value) { return value.empty() ? "" : '"' + value + '"'; }
template <class Scalar, int rows>
std::string value_words(const Eigen::Matrix<Scalar, rows, 1>& value) {
  std::string words;
  for (const Scalar each : value)
    words += (words.empty() ? "[" : ", ") + number_text(static_cast<double>(each));
  return words + "]";
}
template <class Value>
std::string value_words(const std::optional<Value>&) {
  return "";
}
template <class Value>
std::string value_words(const std::vector<Value>&) {
  return "";
}

template <class Owner>
const Owner& defaults() {
  static const Owner owner{};
  return owner;
}

template <class Owner>
std::string default_words(const SceneKey<Owner>& key) {
  if (key.needed) return "needed";
  if (!key.otherwise.empty()) return std::string(key.otherwise);
  return std::visit(
      [&](const auto member) {
        auto value = defaults<Owner>().*member;
        if constexpr (std::is_same_v<decltype(value), double> ||
                      std::is_same_v<decltype(value), Eigen::Vector2d>)
          if (key.unit == "degrees") value *= 180 / std::numbers::pi;
        const std::string words = value_words(value);
        return words.empty() ? "none" : words;
      },
      key.target);
}

template <class Owner>
void add_rows(const SceneTable<Owner>& table, std::string& text) {
  for (const SceneKey<Owner>& key : table.keys) {
    std::string kind = std::visit([&](const auto member) { return kind_words(key, member); }, key.target);
    const std::string range = range_words(key);
    if (!range.empty()) kind += " " + range;
    if (!key.word.empty()) kind += ", or \"" + std::string(key.word) + "\"";
    text += "| `" + std::string(key.name) + "` | " + kind + " | " + std::string(key.unit) + " | " +
            default_words(key) + " | " + std::string(key.meaning) + " |\n";
  }
}

constexpr const char* head = "| key | value | unit | default | what it is |\n|---|---|---|---|---|\n";

template <class Owner>
void add_table(const SceneTable<Owner>& table, std::string& text) {
  text += "### " +
          (table.header.empty() ? std::string("At the top") : '`' + std::string(table.header) + '`') +
          "\n\n" + std::string(table.meaning) + "\n\n" + head;
  add_rows(table, text);
}

void add_settings(std::span<const KnownSetting> settings, SettingScope scope, const char* title,
                  std::string& text) {
  text += std::string("\n### ") + title + "\n\n| key | value | what it is |\n|---|---|---|\n";
  for (const KnownSetting& setting : settings) {
    if (setting.scope != scope) continue;
    text += "| `" + setting.key + "` | " + wanted_of(setting.kind) + " | " + setting.meaning + " |\n";
  }
}

}  // namespace

const char* wanted_of(SettingKind kind) {
  switch (kind) {
    case SettingKind::number:
      return "a number";
    case SettingKind::integer:
      return "a whole number";
    case SettingKind::text:
      return "a text";
    case SettingKind::file:
      return "a text or a file";
    case SettingKind::toggle:
      return "true or false";
    case SettingKind::list:
      return "a list of numbers or texts";
  }
  return "";
}

const SceneKeys& scene_keys() {
  static const SceneKeys keys = all_keys();
  return keys;
}

template <class Owner>
std::string wanted_of(const SceneKey<Owner>& key) {
  std::string words = std::visit([&](const auto member) { return kind_words(key, member); }, key.target);
  const std::string range = range_words(key);
  if (!range.empty()) words += " " + range;
  if (!key.unit.empty()) words += " [" + std::string(key.unit) + "]";
  if (!key.word.empty()) words += ", or \"" + std::string(key.word) + "\"";
  return words;
}

template std::string wanted_of(const SceneKey<Scene>&);
template std::string wanted_of(const SceneKey<SceneGround>&);
template std::string wanted_of(const SceneKey<SceneSky>&);
template std::string wanted_of(const SceneKey<SceneMedium>&);
template std::string wanted_of(const SceneKey<SceneCamera>&);
template std::string wanted_of(const SceneKey<CameraKey>&);
template std::string wanted_of(const SceneKey<ScenePicture>&);
template std::string wanted_of(const SceneKey<SceneObject>&);
template std::string wanted_of(const SceneKey<Crowd>&);
template std::string wanted_of(const SceneKey<Instance>&);
template std::string wanted_of(const SceneKey<Grid>&);
template std::string wanted_of(const SceneKey<Scatter>&);
template std::string wanted_of(const SceneKey<SceneGrass>&);
template std::string wanted_of(const SceneKey<SceneDrift>&);
template std::string wanted_of(const SceneKey<SceneImpression>&);
template std::string wanted_of(const SceneKey<SceneVolume>&);
template std::string wanted_of(const SceneKey<SceneGusts>&);

std::string scene_reference(std::span<const KnownSetting> settings) {
  const SceneKeys& keys = scene_keys();
  std::string text;
  const auto add = [&](const auto& table) {
    if (!text.empty()) text += "\n";
    add_table(table, text);
  };
  add(keys.scene);
  add(keys.ground);
  add(keys.sky);
  add(keys.medium);
  add(keys.camera);
  add(keys.path);
  add(keys.picture);
  add(keys.object);
  add_rows(keys.crowd, text);
  add(keys.instance);
  add(keys.grid);
  add(keys.scatter);
  add(keys.grass);
  add(keys.drift);
  add(keys.impression);
  add_rows(keys.crowd, text);
  add(keys.volume);
  add(keys.gusts);
  if (settings.empty()) return text;
  add_settings(settings, SettingScope::wind, "`[wind]`", text);
  add_settings(settings, SettingScope::film, "`[motion]`", text);
  add_settings(settings, SettingScope::object, "`[motion]` for all objects, `[[objects]]` for one", text);
  return text;
}

}  // namespace tremula
