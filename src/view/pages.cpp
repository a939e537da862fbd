#include "view/pages.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "cli/path_words.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/text.h"
#include "formats/mitsuba/mitsuba_writer.h"
#include "formats/nori/nori_writer.h"
#include "report_assets.h"
#include "scene/film_projection.h"
#include "scene/material_numbers.h"
#include "scene/view.h"

namespace etendue::view {
namespace {

constexpr std::chrono::seconds kLongestWait{10};

Response asset(std::string_view text, const char* type) {
  return {.status = 200, .type = type, .parts = {std::make_shared<const std::string>(text)}};
}

Response wrong(const std::string& sentence) {
  return text_response(400, sentence + "\n");
}

// --- parameters ---

std::optional<double> number_of(std::string_view text) {
  double value = 0;
  if (text::parse_double(text, value) != text::NumberError::none) return std::nullopt;
  return value;
}

std::optional<double> number_in(const Request& request, std::string_view name) {
  const std::string* text = request.find(name);
  return text == nullptr ? std::nullopt : number_of(*text);
}

/// A number from 0 to 2^53, beyond which JavaScript's numbers are no longer exact integers.
std::optional<std::uint64_t> count_in(const Request& request, std::string_view name) {
  const std::optional<double> number = number_in(request, name);
  if (!number || !(*number >= 0.0) || *number > 0x1p53 || *number != std::floor(*number)) return std::nullopt;
  return static_cast<std::uint64_t>(*number);
}

/// Numbers separated by commas; nothing if one of them is not a number.
std::vector<double> numbers_of(std::string_view list) {
  std::vector<double> numbers;
  for (const std::string_view piece : text::split(list, ',')) {
    const std::optional<double> number = number_of(piece);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<glm::dvec3> vector_in(const Request& request, std::string_view name) {
  const std::string* text = request.find(name);
  const std::vector<double> n = text == nullptr ? std::vector<double>() : numbers_of(*text);
  return n.size() == 3 ? std::optional(glm::dvec3(n[0], n[1], n[2])) : std::nullopt;
}

// --- the state ---

const char* to_text(Phase phase) {
  switch (phase) {
    case Phase::opening:
      return "opening";
    case Phase::rendering:
      return "rendering";
    case Phase::resting:
      return "resting";
    case Phase::done:
      return "done";
    case Phase::stopped:
      return "stopped";
  }
  return "";
}

Json vector_json(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

bool has_fov(const Camera& camera) {
  return camera.type == Camera::Type::perspective || camera.type == Camera::Type::thin_lens;
}

/// The matrix that projects points to positions in the picture, row by row; see FilmProjection.
Json projection_json(const Camera& camera) {
  const std::optional<FilmProjection> projection = film_projection(camera);
  if (!projection) return {};
  Json matrix = Json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) matrix.push_back(projection->matrix[column][row]);
  }
  const bool plane = projection->kind == FilmProjection::Kind::plane;
  const FilmWindow& w = camera.window;
  const glm::dvec2 origin = w.origin + w.principal_offset;
  return {{"kind", plane ? "plane" : "sphere"},
          {"matrix", matrix},
          {"origin", {origin.x, origin.y}},
          {"pixels", {camera.width / w.size.x, camera.height / w.size.y}}};
}

Json camera_json(const State& state) {
  const Camera& camera = state.camera;
  // Tells the page which way the picture moves when the camera turns: mirrored cameras have x on the other side.
  const bool mirrored = glm::determinant(glm::dmat3(camera.world_from_camera)) < 0.0;
  return {{"eye", vector_json(state.pose.eye)},
          {"target", vector_json(state.pose.target)},
          {"up", vector_json(state.pose.up)},
          {"fov", has_fov(camera) ? Json(camera.fov) : Json()},
          {"aperture", has_fov(camera) ? Json(camera.aperture.radius) : Json()},
          {"focus", camera.aperture.focus_distance},
          {"mirrored", mirrored},
          {"projection", projection_json(camera)},
          {"mover", state.mover}};
}

Json integrator_json(const Integrator& integrator) {
  return {{"path", integrator.type == Integrator::Type::path},
          {"maxDepth", integrator.max_depth >= Integrator::kUnlimitedDepth ? Json() : Json(integrator.max_depth)},
          {"rrDepth", integrator.rr_depth},
          {"nee", integrator.nee},
          {"mis", integrator.mis}};
}

/// The binary data that follow the JSON.
struct Parts {
  Bytes mean, error;
  std::shared_ptr<const Layer> layer;
};

Json to_json(const State& state, const Parts& parts, const std::string& complaint) {
  const bool layer = parts.layer != nullptr;
  return {{"version", state.version},
          {"picture", state.picture},
          {"width", state.width},
          {"height", state.height},
          {"fullWidth", state.full_width},
          {"fullHeight", state.full_height},
          {"crop", state.crop ? Json(std::vector<std::uint32_t>{state.crop->x, state.crop->y, state.crop->width,
                                                                state.crop->height})
                              : Json()},
          {"hasPicture", parts.mean != nullptr},
          {"hasError", parts.error != nullptr},
          {"layer", layer ? Json({{"number", parts.layer->number},
                                  {"width", parts.layer->width},
                                  {"height", parts.layer->height},
                                  {"components", parts.layer->components}})
                          : Json()},
          {"samples", state.samples},
          {"target", state.target},
          {"samplesPerSecond", state.samples_per_second},
          {"relativeError", state.relative_error},
          {"secondsLeft", state.seconds_left},
          {"rejected", state.rejected},
          {"phase", to_text(state.phase)},
          {"paused", state.paused},
          {"problem", text::printable_lines(state.problem.empty() ? complaint : state.problem)},
          {"scene", text::printable(state.scene, 200)},
          {"device", state.device},
          {"driver", state.driver},
          {"loads", state.loads},
          {"integrator", integrator_json(state.integrator)},
          {"materials", state.materials},
          {"lights", state.lights},
          {"camera", camera_json(state)}};
}

/// The AOV of that name; nothing for names that the page cannot show.
std::optional<Aov> shown_aov(const Request& request) {
  const std::string* name = request.find("aov");
  const std::optional<Aov> aov = name == nullptr ? std::nullopt : aov_named(*name);
  return aov == Aov::hit || aov == Aov::alpha ? std::nullopt : aov;
}

Response next(Preview& preview, const Request& request) {
  const std::uint64_t version = count_in(request, "version").value_or(0);
  const Looked looked{.error = count_in(request, "error").value_or(0) == 1, .aov = shown_aov(request)};
  const State state = preview.wait(version, looked, kLongestWait);
  Parts parts;
  if (state.picture != count_in(request, "picture").value_or(0)) {
    parts.mean = state.mean;
    if (looked.error) parts.error = state.error;
  }
  std::string complaint;
  if (looked.aov) {
    complaint = aov_complaint(state.integrator, *looked.aov);
    const auto found = state.layers.find(traits(*looked.aov).name);
    if (found != state.layers.end() && found->second->number != count_in(request, "layer").value_or(0))
      parts.layer = found->second;
  }
  std::string json = to_json(state, parts, complaint).dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');  // so that the halves are aligned
  std::string head;
  for (int shift = 0; shift < 32; shift += 8) head += static_cast<char>((json.size() >> shift) & 0xffu);
  Response out{
      .status = 200, .type = "application/octet-stream", .parts = {std::make_shared<const std::string>(head + json)}};
  if (parts.mean) out.parts.push_back(parts.mean);
  if (parts.error) out.parts.push_back(parts.error);
  if (parts.layer) out.parts.push_back(parts.layer->values);
  return out;
}

Response json_response(const Json& json) {
  return {
      .status = 200, .type = "application/json", .parts = {std::make_shared<const std::string>(json.dump() + "\n")}};
}

/// Answers with the result of `tell` for the pixel x, y.
template <class Tell>
Response of_pixel(const Request& request, const Tell& tell) {
  constexpr std::uint64_t kMost = 0xffffffffu;
  const auto x = count_in(request, "x"), y = count_in(request, "y");
  if (!x || !y || *x > kMost || *y > kMost) return wrong("x and y must be the coordinates of a pixel, from 0 on.");
  try {
    return json_response(tell(static_cast<std::uint32_t>(*x), static_cast<std::uint32_t>(*y)));
  } catch (const Error& error) {
    return text_response(error.kind() == ErrorKind::usage ? 409 : 500, fmt::format("{}\n", error.what()));
  }
}

Response point(Preview& preview, const Request& request) {
  return of_pixel(request, [&](std::uint32_t x, std::uint32_t y) {
    const Point point = preview.point_at(x, y);
    return Json({{"hit", point.hit},
                 {"position", vector_json(point.position)},
                 {"focus", point.focus},
                 {"material", point.material},
                 {"light", point.light ? Json(*point.light) : Json()}});
  });
}

Json path_json(const std::vector<PathVertex>& path) {
  Json out = Json::array();
  for (const PathVertex& vertex : path) {
    const cli::VertexWords words = cli::words_of(vertex);
    out.push_back({{"meets", words.meets},
                   {"light", words.light},
                   {"reached", words.reached},
                   {"lobe", words.lobe},
                   {"survives", words.survives},
                   {"met", vertex.instance != PathVertex::kNone},
                   {"from", vector_json(glm::dvec3(vertex.from))},
                   {"to", vector_json(glm::dvec3(vertex.to))},
                   {"radiance", {vertex.radiance.x, vertex.radiance.y, vertex.radiance.z}}});
  }
  return out;
}

Response explain(Preview& preview, const Request& request) {
  const std::uint64_t sample = count_in(request, "sample").value_or(0);
  if (sample > 0xffffffffu) return wrong("sample must be below 2^32.");
  const std::string* by = request.find("by");
  const bool by_reference = by != nullptr && *by == "reference";
  return of_pixel(request, [&](std::uint32_t x, std::uint32_t y) {
    const auto number = static_cast<std::uint32_t>(sample);
    const Told told = by_reference ? preview.explain_by_reference(x, y, number) : preview.explain(x, y, number);
    return Json({{"device", told.device}, {"path", path_json(told.path)}});
  });
}

// --- materials and lights ---

/// A number as JSON; infinity becomes null.
Json finite_json(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json value_json(const MaterialNumber& number) {
  if (!number.is_color) return finite_json(number.value.x);
  return {finite_json(number.value.x), finite_json(number.value.y), finite_json(number.value.z)};
}

bool is_changed(const std::vector<MaterialNumber>& own, const std::vector<MaterialNumber>& now) {
  return !std::ranges::equal(own, now, {}, &MaterialNumber::value, &MaterialNumber::value);
}

constexpr std::size_t kMostListed = 2000;  // that a list can reasonably show

/// Names and types of all materials.
Response material_list(Preview& preview) {
  const Palette palette = preview.palette();
  Json list = Json::array();
  const std::size_t count = palette.scene ? palette.materials->size() : 0;
  for (std::uint32_t row = 0; row < std::min(count, kMostListed); ++row) {
    const Material& material = (*palette.materials)[row];
    list.push_back({{"name", text::printable(material.name, 100)},
                    {"type", type_name(material)},
                    {"changed", is_changed(numbers_of(palette.scene->materials[row]), numbers_of(material))}});
  }
  return json_response({{"count", count}, {"rows", list}});
}

/// The row named by a request; nothing if there are not so many.
std::optional<std::uint32_t> row_in(const Request& request, std::size_t count) {
  const std::optional<std::uint64_t> row = count_in(request, "row");
  if (!row || *row >= count) return std::nullopt;
  return static_cast<std::uint32_t>(*row);
}
std::optional<std::uint32_t> material_row(const Request& request, const Palette& palette) {
  return row_in(request, palette.scene ? palette.materials->size() : 0);
}

Response no_row(const char* what) {
  return text_response(404, fmt::format("row must be the number of a {} of the scene, from 0 on.\n", what));
}

Json numbers_json(const Scene& scene, const std::vector<MaterialNumber>& own, const std::vector<MaterialNumber>& now) {
  Json numbers = Json::array();
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Json texture = now[i].texture ? Json(text::printable(scene.textures[*now[i].texture].name, 100)) : Json();
    numbers.push_back({{"name", now[i].name},
                       {"color", now[i].is_color},
                       {"value", value_json(now[i])},
                       {"own", value_json(own[i])},
                       {"texture", texture},
                       {"fixed", is_map(now[i])}});
  }
  return numbers;
}

Response material(Preview& preview, const Request& request) {
  const Palette palette = preview.palette();
  const std::optional<std::uint32_t> row = material_row(request, palette);
  if (!row) return no_row("material");
  const Material& shown = (*palette.materials)[*row];
  const Json numbers = numbers_json(*palette.scene, numbers_of(palette.scene->materials[*row]), numbers_of(shown));
  return json_response(
      {{"row", *row}, {"name", text::printable(shown.name, 100)}, {"type", type_name(shown)}, {"numbers", numbers}});
}

/// Names of the lights: that of an emitter is that of the first shape that has it.
std::vector<std::string> light_names(const Scene& scene, const LightSources& lights) {
  std::vector<std::string> names(count_of(lights));
  for (const Instance& instance : scene.instances) {
    if (instance.emitter && names[*instance.emitter].empty()) names[*instance.emitter] = instance.name;
  }
  for (std::size_t i = 0; i < lights.delta_lights.size(); ++i)
    names[lights.emitters.size() + i] = lights.delta_lights[i].name;
  return names;
}

Response light_list(Preview& preview) {
  const Palette palette = preview.palette();
  if (!palette.scene) return json_response({{"count", 0}, {"rows", Json::array()}});
  const LightSources own = light_sources_of(*palette.scene);
  const std::vector<std::string> names = light_names(*palette.scene, *palette.lights);
  // The environment is the last one, and always listed.
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row + 1 < names.size() && rows.size() + 1 < kMostListed; ++row) rows.push_back(row);
  rows.push_back(static_cast<std::uint32_t>(names.size() - 1));
  Json list = Json::array();
  for (const std::uint32_t row : rows) {
    list.push_back({{"row", row},
                    {"name", text::printable(names[row], 100)},
                    {"type", type_name(*palette.lights, row)},
                    {"changed", is_changed(numbers_of(own, row), numbers_of(*palette.lights, row))}});
  }
  return json_response({{"count", names.size()}, {"rows", list}});
}

std::optional<std::uint32_t> light_row(const Request& request, const Palette& palette) {
  return row_in(request, palette.scene ? count_of(*palette.lights) : 0);
}

Response light(Preview& preview, const Request& request) {
  const Palette palette = preview.palette();
  const std::optional<std::uint32_t> row = light_row(request, palette);
  if (!row) return no_row("light");
  const LightSources own = light_sources_of(*palette.scene);
  return json_response(
      {{"row", *row},
       {"name", text::printable(light_names(*palette.scene, own)[*row], 100)},
       {"type", type_name(own, *row)},
       {"numbers", numbers_json(*palette.scene, numbers_of(own, *row), numbers_of(*palette.lights, *row))}});
}

/// The material as text for a scene file.
Response material_text(Preview& preview, const Request& request) {
  const Palette palette = preview.palette();
  const std::optional<std::uint32_t> row = material_row(request, palette);
  if (!row) return no_row("material");
  Scene scene;
  scene.file = palette.scene->file;
  scene.materials = *palette.materials;
  scene.textures = palette.scene->textures;
  scene.bitmaps = palette.scene->bitmaps;
  const std::string* dialect = request.find("dialect");
  const bool mitsuba = dialect != nullptr && *dialect == "mitsuba";
  try {
    return text_response(200, mitsuba ? mitsuba_bsdf_element(scene, *row) : bsdf_element(scene, *row));
  } catch (const Error& error) {
    return text_response(409, fmt::format("{}\n", error.what()));
  }
}

/// One number, or three; "inf" is allowed.
std::optional<glm::dvec3> value_of(std::string_view text) {
  if (text == "inf") return glm::dvec3(INFINITY);
  const std::vector<double> n = numbers_of(text);
  if (n.size() == 1) return glm::dvec3(n[0]);
  return n.size() == 3 ? std::optional(glm::dvec3(n[0], n[1], n[2])) : std::nullopt;
}

/// Calls change(what the request wants).
template <class Change>
Response change_number(std::uint32_t row, const Request& request, const Change& change) {
  NumberChange wanted{.row = row, .going_on = count_in(request, "moving").value_or(0) == 1};
  if (const std::string* name = request.find("name"); name != nullptr) wanted.name = *name;
  if (const std::string* value = request.find("value"); value != nullptr) {
    wanted.value = value_of(*value);
    if (!wanted.value) return wrong("value is a number, or three separated by commas.");
  }
  try {
    change(wanted);
  } catch (const Error& error) {
    return text_response(409, fmt::format("{}\n", text::printable_lines(error.what())));
  }
  return text_response(204, "");
}

Response change_material(Preview& preview, const Request& request) {
  const std::optional<std::uint32_t> row = material_row(request, preview.palette());
  if (!row) return no_row("material");
  return change_number(*row, request, [&](const NumberChange& wanted) { preview.change(wanted); });
}

Response change_light(Preview& preview, const Request& request) {
  const std::optional<std::uint32_t> row = light_row(request, preview.palette());
  if (!row) return no_row("light");
  return change_number(*row, request, [&](const NumberChange& wanted) { preview.change_light(wanted); });
}

// --- what changes something ---

Response move_camera(Preview& preview, const Request& request) {
  const auto eye = vector_in(request, "eye"), target = vector_in(request, "target"), up = vector_in(request, "up");
  if (!eye || !target || !up) return wrong("eye, target and up must be three numbers each, separated by commas.");
  Move move{.pose = {*eye, *target, *up}};
  if (const std::string complaint = pose_complaint(move.pose); !complaint.empty())
    return wrong(fmt::format("The camera cannot be placed there: {}.", complaint));
  if (request.find("fov") != nullptr) {
    const std::optional<double> fov = number_in(request, "fov");
    if (!fov || !(*fov >= 0.1) || *fov > 179.0) return wrong("fov must be from 0.1 to 179 degrees.");
    move.fov = *fov;
  }
  constexpr double kLargest = 1e15;
  move.aperture = number_in(request, "aperture");
  if (request.find("aperture") != nullptr && !(move.aperture.value_or(-1.0) >= 0.0 && *move.aperture < kLargest))
    return wrong("aperture must be a radius of at least 0.");
  move.focus = number_in(request, "focus");
  if (request.find("focus") != nullptr && !(move.focus.value_or(-1.0) > 0.0 && *move.focus < kLargest))
    return wrong("focus must be a distance above 0.");
  move.going_on = count_in(request, "moving").value_or(0) == 1;
  move.mover = count_in(request, "mover").value_or(0);
  preview.move(move);
  return text_response(204, "");
}

/// An empty text means no crop; nothing is returned if the text is invalid.
std::optional<std::optional<Crop>> crop_of(std::string_view text) {
  if (text.empty()) return std::optional<Crop>();
  const std::vector<double> n = numbers_of(text);
  if (n.size() != 4 || n[2] < 1.0 || n[3] < 1.0) return std::nullopt;
  if (std::ranges::any_of(n, [](double v) { return !(v >= 0.0) || v > 1e6 || v != std::floor(v); }))
    return std::nullopt;
  const auto whole = [&](std::size_t i) { return static_cast<std::uint32_t>(n[i]); };
  return Crop{whole(0), whole(1), whole(2), whole(3)};
}

Response change_settings(Preview& preview, const Request& request) {
  if (request.find("samples") != nullptr) {
    constexpr std::uint64_t kMost = 1u << 24;
    const std::optional<std::uint64_t> samples = count_in(request, "samples");
    if (!samples || *samples == 0 || *samples > kMost)
      return wrong(fmt::format("samples must be from 1 to {}.", kMost));
    preview.set_samples(static_cast<std::uint32_t>(*samples));
  }
  if (const std::string* text = request.find("crop"); text != nullptr) {
    const std::optional<std::optional<Crop>> crop = crop_of(*text);
    if (!crop) return wrong("crop must be x,y,width,height in pixels, or empty for the whole film.");
    preview.set_crop(*crop);
  }
  IntegratorChange change;
  for (const auto& [name, depth, least] : {std::tuple{"maxDepth", &change.max_depth, std::uint64_t{1}},
                                           std::tuple{"rrDepth", &change.rr_depth, std::uint64_t{0}}}) {
    if (request.find(name) == nullptr) continue;
    const std::optional<std::uint64_t> value = count_in(request, name);
    if (!value || *value < least || *value > Integrator::kUnlimitedDepth)
      return wrong(fmt::format("{} must be from {} to {}.", name, least, Integrator::kUnlimitedDepth));
    *depth = static_cast<std::uint32_t>(*value);
  }
  if (request.find("nee") != nullptr) change.nee = count_in(request, "nee").value_or(0) == 1;
  if (request.find("mis") != nullptr) change.mis = count_in(request, "mis").value_or(0) == 1;
  if (change.max_depth || change.rr_depth || change.nee || change.mis) preview.change(change);
  if (request.find("paused") != nullptr) preview.set_paused(count_in(request, "paused").value_or(0) == 1);
  return text_response(204, "");
}

// --- files to keep ---

/// A file name made from the scene's name, safe for use in a header.
std::string file_name(const State& state, const char* extension) {
  std::string name;
  for (const char c : state.scene) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    if (name.size() < 80) name += plain ? c : '_';
  }
  return (name.empty() ? "picture" : name) + extension;
}

Response snapshot(Preview& preview, const Request& request, const char* extension, const char* type) {
  const std::string* tone = request.find("tone");
  const auto& names = tone_map_names();
  if (tone != nullptr && std::find(names.begin(), names.end(), *tone) == names.end())
    return wrong(fmt::format("tone must be one of {}.", text::join(names)));
  const double exposure = number_in(request, "exposure").value_or(0.0);
  if (!(std::abs(exposure) <= 100.0)) return wrong("exposure must be from -100 to 100 stops.");
  try {
    std::string bytes = preview.snapshot(
        extension, {.tone_map = tone == nullptr ? ToneMap::none : tone_map_of(*tone), .exposure = exposure});
    const std::string name = file_name(preview.wait(0, {}, {}), extension);
    return {.status = 200,
            .type = type,
            .parts = {std::make_shared<const std::string>(std::move(bytes))},
            .headers = {{"Content-Disposition", fmt::format("attachment; filename=\"{}\"", name)}}};
  } catch (const Error& error) {
    return text_response(error.kind() == ErrorKind::usage ? 409 : 500, fmt::format("{}\n", error.what()));
  }
}

Response camera_text(Preview& preview, const Request& request) {
  const State state = preview.wait(0, {}, {});
  const std::string* dialect = request.find("dialect");
  if (state.loads == 0) return text_response(409, "There is no camera yet.\n");
  try {
    if (dialect != nullptr && *dialect == "mitsuba") return text_response(200, sensor_element(state.camera, {}));
    if (dialect != nullptr && *dialect == "option") {
      const Pose& p = state.pose;
      return text_response(200, fmt::format("--camera {},{},{},{},{},{},{}\n", p.eye.x, p.eye.y, p.eye.z, p.target.x,
                                            p.target.y, p.target.z, state.camera.fov));
    }
    return text_response(200, camera_element(state.camera));
  } catch (const Error& error) {
    return text_response(409, fmt::format("{}\n", error.what()));
  }
}

Response get(Preview& preview, const std::string& place, const Request& request) {
  if (place == "/") return asset(assets::view_html, "text/html; charset=utf-8");
  if (place == "/view.css") return asset(assets::view_css, "text/css; charset=utf-8");
  if (place == "/view.js") return asset(assets::view_js, "text/javascript; charset=utf-8");
  if (place == "/path.js") return asset(assets::path_js, "text/javascript; charset=utf-8");
  if (place == "/materials.js") return asset(assets::materials_js, "text/javascript; charset=utf-8");
  if (place == "/next") return next(preview, request);
  if (place == "/picture.exr") return snapshot(preview, request, ".exr", "image/x-exr");
  if (place == "/picture.png") return snapshot(preview, request, ".png", "image/png");
  if (place == "/point") return point(preview, request);
  if (place == "/explain") return explain(preview, request);
  if (place == "/camera.xml") return camera_text(preview, request);
  if (place == "/materials") return material_list(preview);
  if (place == "/material") return material(preview, request);
  if (place == "/lights") return light_list(preview);
  if (place == "/light") return light(preview, request);
  if (place == "/material.xml") return material_text(preview, request);
  return text_response(404, "There is no such page.\n");
}

Response post(Preview& preview, const std::string& place, const Request& request) {
  if (place == "/camera") return move_camera(preview, request);
  if (place == "/settings") return change_settings(preview, request);
  if (place == "/material") return change_material(preview, request);
  if (place == "/light") return change_light(preview, request);
  if (place == "/reset") return preview.reset_camera(), text_response(204, "");
  if (place == "/reload") return preview.reload(), text_response(204, "");
  return text_response(404, "There is no such page.\n");
}

}  // namespace

Response answer(Preview& preview, const std::string& place, const Request& request) {
  Response out = request.method == "POST" ? post(preview, place, request) : get(preview, place, request);
  // Loads nothing from other sites, sends nothing to them, and caches nothing.
  out.headers.insert(out.headers.end(),
                     {{"Content-Security-Policy",
                       "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
                       "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
                      {"X-Content-Type-Options", "nosniff"},
                      {"Referrer-Policy", "no-referrer"},
                      {"Cross-Origin-Resource-Policy", "same-origin"},
                      {"Cross-Origin-Opener-Policy", "same-origin"},
                      {"Cache-Control", "no-store"}});
  return out;
}

}  // namespace etendue::view
