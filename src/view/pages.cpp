#include "view/pages.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/json.h"
#include "core/text.h"
#include "formats/mitsuba/mitsuba_writer.h"
#include "formats/nori/nori_writer.h"
#include "report_assets.h"

namespace etendue::view {
namespace {

constexpr std::chrono::seconds kLongestWait{10};

Response asset(std::string_view text, const char* type) {
  return {.status = 200, .type = type, .parts = {std::make_shared<const std::string>(text)}};
}

Response wrong(const std::string& sentence) {
  return text_response(400, sentence + "\n");
}

// --- parameters ---------------------------------------------------------------------------------------------------

std::optional<double> number_of(std::string_view text) {
  double value = 0;
  if (text::parse_double(text, value) != text::NumberError::none) return std::nullopt;
  return value;
}

std::optional<double> number_in(const Request& request, std::string_view name) {
  const std::string* text = request.find(name);
  return text == nullptr ? std::nullopt : number_of(*text);
}

/// A number from 0 to 2^53, beyond which scripts have no whole numbers.
std::optional<std::uint64_t> count_in(const Request& request, std::string_view name) {
  const std::optional<double> number = number_in(request, name);
  if (!number || !(*number >= 0.0) || *number > 0x1p53 || *number != std::floor(*number)) return std::nullopt;
  return static_cast<std::uint64_t>(*number);
}

std::optional<glm::dvec3> vector_in(const Request& request, std::string_view name) {
  const std::string* text = request.find(name);
  if (text == nullptr) return std::nullopt;
  glm::dvec3 out;
  std::string_view rest = *text;
  for (int i = 0; i < 3; ++i) {
    const std::size_t comma = rest.find(',');
    if ((comma == std::string_view::npos) != (i == 2)) return std::nullopt;
    const std::optional<double> number = number_of(rest.substr(0, comma));
    if (!number) return std::nullopt;
    out[i] = *number;
    rest.remove_prefix(i == 2 ? 0 : comma + 1);
  }
  return out;
}

// --- the state ------------------------------------------------------------------------------------------------------

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

Json camera_json(const State& state) {
  const Camera& camera = state.camera;
  // Which way the picture goes when the camera turns: mirrored cameras have x on the other side.
  const bool mirrored = glm::determinant(glm::dmat3(camera.world_from_camera)) < 0.0;
  return {{"eye", vector_json(state.pose.eye)},
          {"target", vector_json(state.pose.target)},
          {"up", vector_json(state.pose.up)},
          {"fov", has_fov(camera) ? Json(camera.fov) : Json()},
          {"mirrored", mirrored},
          {"mover", state.mover}};
}

Json to_json(const State& state, bool with_picture, bool with_error) {
  return {{"version", state.version},
          {"picture", state.picture},
          {"width", state.width},
          {"height", state.height},
          {"fullWidth", state.full_width},
          {"fullHeight", state.full_height},
          {"hasPicture", with_picture},
          {"hasError", with_error},
          {"samples", state.samples},
          {"target", state.target},
          {"samplesPerSecond", state.samples_per_second},
          {"relativeError", state.relative_error},
          {"secondsLeft", state.seconds_left},
          {"rejected", state.rejected},
          {"phase", to_text(state.phase)},
          {"paused", state.paused},
          {"problem", text::printable_lines(state.problem)},
          {"scene", text::printable(state.scene, 200)},
          {"device", state.device},
          {"driver", state.driver},
          {"loads", state.loads},
          {"camera", camera_json(state)}};
}

Response next(Preview& preview, const Request& request) {
  const std::uint64_t version = count_in(request, "version").value_or(0);
  const std::uint64_t known = count_in(request, "picture").value_or(0);
  const bool error = count_in(request, "error").value_or(0) == 1;
  const State state = preview.wait(version, error, kLongestWait);
  const bool with_picture = state.mean != nullptr && state.picture != known;
  const bool with_error = with_picture && error && state.error != nullptr;
  std::string json = to_json(state, with_picture, with_error).dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');  // so that the halves are aligned
  std::string head;
  for (int shift = 0; shift < 32; shift += 8) head += static_cast<char>((json.size() >> shift) & 0xffu);
  Response out{
      .status = 200, .type = "application/octet-stream", .parts = {std::make_shared<const std::string>(head + json)}};
  if (with_picture) out.parts.push_back(state.mean);
  if (with_error) out.parts.push_back(state.error);
  return out;
}

// --- what changes something
// -------------------------------------------------------------------------------------------

Response move_camera(Preview& preview, const Request& request) {
  const auto eye = vector_in(request, "eye"), target = vector_in(request, "target"), up = vector_in(request, "up");
  if (!eye || !target || !up) return wrong("eye, target and up are three numbers each, with commas between them.");
  Move move{.pose = {*eye, *target, *up}};
  if (const std::string complaint = pose_complaint(move.pose); !complaint.empty())
    return wrong(fmt::format("The camera cannot stand like this: {}.", complaint));
  if (request.find("fov") != nullptr) {
    const std::optional<double> fov = number_in(request, "fov");
    if (!fov || !(*fov >= 0.1) || *fov > 179.0) return wrong("fov is from 0.1 to 179 degrees.");
    move.fov = *fov;
  }
  move.going_on = count_in(request, "moving").value_or(0) == 1;
  move.mover = count_in(request, "mover").value_or(0);
  preview.move(move);
  return text_response(204, "");
}

Response change_settings(Preview& preview, const Request& request) {
  if (request.find("samples") != nullptr) {
    constexpr std::uint64_t kMost = 1u << 24;
    const std::optional<std::uint64_t> samples = count_in(request, "samples");
    if (!samples || *samples == 0 || *samples > kMost) return wrong(fmt::format("samples is from 1 to {}.", kMost));
    preview.set_samples(static_cast<std::uint32_t>(*samples));
  }
  if (request.find("paused") != nullptr) preview.set_paused(count_in(request, "paused").value_or(0) == 1);
  return text_response(204, "");
}

// --- files to keep
// ----------------------------------------------------------------------------------------------------

/// A name for a file that came from a scene, fit for a header.
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
    return wrong(fmt::format("tone is one of {}.", text::join(names)));
  const double exposure = number_in(request, "exposure").value_or(0.0);
  if (!(std::abs(exposure) <= 100.0)) return wrong("exposure is from -100 to 100 stops.");
  try {
    std::string bytes = preview.snapshot(
        extension, {.tone_map = tone == nullptr ? ToneMap::none : tone_map_of(*tone), .exposure = exposure});
    const std::string name = file_name(preview.wait(0, false, {}), extension);
    return {.status = 200,
            .type = type,
            .parts = {std::make_shared<const std::string>(std::move(bytes))},
            .headers = {{"Content-Disposition", fmt::format("attachment; filename=\"{}\"", name)}}};
  } catch (const Error& error) {
    return text_response(error.kind() == ErrorKind::usage ? 409 : 500, fmt::format("{}\n", error.what()));
  }
}

Response camera_text(Preview& preview, const Request& request) {
  const State state = preview.wait(0, false, {});
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
  if (place == "/next") return next(preview, request);
  if (place == "/picture.exr") return snapshot(preview, request, ".exr", "image/x-exr");
  if (place == "/picture.png") return snapshot(preview, request, ".png", "image/png");
  if (place == "/camera.xml") return camera_text(preview, request);
  return text_response(404, "There is no such page.\n");
}

Response post(Preview& preview, const std::string& place, const Request& request) {
  if (place == "/camera") return move_camera(preview, request);
  if (place == "/settings") return change_settings(preview, request);
  if (place == "/reset") return preview.reset_camera(), text_response(204, "");
  if (place == "/reload") return preview.reload(), text_response(204, "");
  return text_response(404, "There is no such page.\n");
}

}  // namespace

Response answer(Preview& preview, const std::string& place, const Request& request) {
  Response out = request.method == "POST" ? post(preview, place, request) : get(preview, place, request);
  // Nothing from elsewhere, nothing into elsewhere, nothing kept.
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
