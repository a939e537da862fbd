/// shaders/gpu_types.h means the same on both sides: the Offset decorations of the built SPIR-V against offsetof, the
/// SpecId decorations against the ids that the host uses.

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gpu_types.h"

namespace etendue::gpu {
namespace {

struct Member {
  std::string name;
  std::size_t offset;
};
struct Layout {
  std::vector<Member> members;
  std::size_t size;
};

#define MEMBER(Type, name)      \
  Member {                      \
#name, offsetof(Type, name) \
  }

// The layout that the C++ compiler gives each struct.
const std::map<std::string, Layout> kHostLayouts = {
    {"Record", {{MEMBER(Record, a), MEMBER(Record, b), MEMBER(Record, c)}, sizeof(Record)}},
    {"Primitive",
     {{MEMBER(Primitive, p0), MEMBER(Primitive, instance), MEMBER(Primitive, p1), MEMBER(Primitive, primitive),
       MEMBER(Primitive, p2), MEMBER(Primitive, kind)},
      sizeof(Primitive)}},
    {"Instance",
     {{MEMBER(Instance, radiance), MEMBER(Instance, light_prob), MEMBER(Instance, material),
       MEMBER(Instance, first_triangle), MEMBER(Instance, light_area), MEMBER(Instance, place)},
      sizeof(Instance)}},
    {"Place",
     {{MEMBER(Place, origin), MEMBER(Place, error), MEMBER(Place, x), MEMBER(Place, relative_error), MEMBER(Place, y),
       MEMBER(Place, side), MEMBER(Place, z), MEMBER(Place, root_determinant), MEMBER(Place, object_x),
       MEMBER(Place, pad0), MEMBER(Place, object_y), MEMBER(Place, pad1), MEMBER(Place, object_z), MEMBER(Place, pad2)},
      sizeof(Place)}},
    {"MaterialRecord",
     {{MEMBER(MaterialRecord, params), MEMBER(MaterialRecord, header), MEMBER(MaterialRecord, specular),
       MEMBER(MaterialRecord, share), MEMBER(MaterialRecord, eta), MEMBER(MaterialRecord, alpha_u),
       MEMBER(MaterialRecord, k), MEMBER(MaterialRecord, alpha_v), MEMBER(MaterialRecord, sheen),
       MEMBER(MaterialRecord, scattered), MEMBER(MaterialRecord, film), MEMBER(MaterialRecord, volume)},
      sizeof(MaterialRecord)}},
    {"MaterialTextures",
     {{MEMBER(MaterialTextures, first), MEMBER(MaterialTextures, begin), MEMBER(MaterialTextures, end),
       MEMBER(MaterialTextures, coat_normals)},
      sizeof(MaterialTextures)}},
    {"TextureUse",
     {{MEMBER(TextureUse, texture_of), MEMBER(TextureUse, floats), MEMBER(TextureUse, least), MEMBER(TextureUse, most)},
      sizeof(TextureUse)}},
    {"TextureRecord",
     {{MEMBER(TextureRecord, header), MEMBER(TextureRecord, first), MEMBER(TextureRecord, width),
       MEMBER(TextureRecord, height), MEMBER(TextureRecord, u_row), MEMBER(TextureRecord, uv_set),
       MEMBER(TextureRecord, v_row), MEMBER(TextureRecord, cutoff), MEMBER(TextureRecord, color0),
       MEMBER(TextureRecord, pad1), MEMBER(TextureRecord, color1), MEMBER(TextureRecord, pad2)},
      sizeof(TextureRecord)}},
    {"InstanceAttributes",
     {{MEMBER(InstanceAttributes, first), MEMBER(InstanceAttributes, layout_bits),
       MEMBER(InstanceAttributes, radiance_texture), MEMBER(InstanceAttributes, pad0)},
      sizeof(InstanceAttributes)}},
    {"LightInstance",
     {{MEMBER(LightInstance, threshold), MEMBER(LightInstance, instance), MEMBER(LightInstance, first_primitive),
       MEMBER(LightInstance, primitive_count)},
      sizeof(LightInstance)}},
    {"LightPrimitive",
     {{MEMBER(LightPrimitive, primitive), MEMBER(LightPrimitive, threshold), MEMBER(LightPrimitive, prob),
       MEMBER(LightPrimitive, cells), MEMBER(LightPrimitive, cell)},
      sizeof(LightPrimitive)}},
    {"LightBounds",
     {{MEMBER(LightBounds, center), MEMBER(LightBounds, radius), MEMBER(LightBounds, axis),
       MEMBER(LightBounds, cos_cone)},
      sizeof(LightBounds)}},
    {"LightPair",
     {{MEMBER(LightPair, left_bounds), MEMBER(LightPair, right_bounds), MEMBER(LightPair, left_power),
       MEMBER(LightPair, right_power), MEMBER(LightPair, left), MEMBER(LightPair, right)},
      sizeof(LightPair)}},
    {"LightTrail",
     {{MEMBER(LightTrail, turns), MEMBER(LightTrail, area), MEMBER(LightTrail, cells), MEMBER(LightTrail, first)},
      sizeof(LightTrail)}},
    {"Frame",
     {{MEMBER(Frame, camera_origin),
       MEMBER(Frame, near_clip),
       MEMBER(Frame, camera_x),
       MEMBER(Frame, far_clip),
       MEMBER(Frame, camera_y),
       MEMBER(Frame, tan_x),
       MEMBER(Frame, camera_z),
       MEMBER(Frame, tan_y),
       MEMBER(Frame, sky_top),
       MEMBER(Frame, filter_weight),
       MEMBER(Frame, sky_horizon),
       MEMBER(Frame, distance_scale),
       MEMBER(Frame, width),
       MEMBER(Frame, height),
       MEMBER(Frame, tiles_x),
       MEMBER(Frame, seed),
       MEMBER(Frame, max_depth),
       MEMBER(Frame, rr_depth),
       MEMBER(Frame, film_exponent),
       MEMBER(Frame, light_instance_count),
       MEMBER(Frame, filter_zero),
       MEMBER(Frame, plane_x),
       MEMBER(Frame, plane_y),
       MEMBER(Frame, plane_depth),
       MEMBER(Frame, lens_offset),
       MEMBER(Frame, lens_slope),
       MEMBER(Frame, lens_rotation),
       MEMBER(Frame, lens_blades),
       MEMBER(Frame, window_offset),
       MEMBER(Frame, window_scale),
       MEMBER(Frame, light_position),
       MEMBER(Frame, ray_length),
       MEMBER(Frame, light_intensity),
       MEMBER(Frame, emitter_samples),
       MEMBER(Frame, bsdf_samples),
       MEMBER(Frame, distant_threshold),
       MEMBER(Frame, delta_light_limit),
       MEMBER(Frame, aov),
       MEMBER(Frame, sky_x),
       MEMBER(Frame, environment_row_count),
       MEMBER(Frame, sky_y),
       MEMBER(Frame, environment_threshold),
       MEMBER(Frame, sky_z),
       MEMBER(Frame, lights_prob),
       MEMBER(Frame, scene_center),
       MEMBER(Frame, pad0)},
      sizeof(Frame)}},
    {"DeltaLight",
     {{MEMBER(DeltaLight, p), MEMBER(DeltaLight, prob), MEMBER(DeltaLight, intensity), MEMBER(DeltaLight, header),
       MEMBER(DeltaLight, forward), MEMBER(DeltaLight, cos_cutoff), MEMBER(DeltaLight, across),
       MEMBER(DeltaLight, cos_beam), MEMBER(DeltaLight, picture_scale), MEMBER(DeltaLight, fade),
       MEMBER(DeltaLight, texture_index), MEMBER(DeltaLight, threshold), MEMBER(DeltaLight, number),
       MEMBER(DeltaLight, cutoff_turns), MEMBER(DeltaLight, pad0)},
      sizeof(DeltaLight)}},
    {"EnvironmentRow",
     {{MEMBER(EnvironmentRow, density), MEMBER(EnvironmentRow, upper_edge), MEMBER(EnvironmentRow, lower_edge),
       MEMBER(EnvironmentRow, column_count)},
      sizeof(EnvironmentRow)}},
    {"EnvironmentTexel",
     {{MEMBER(EnvironmentTexel, radiance), MEMBER(EnvironmentTexel, words)}, sizeof(EnvironmentTexel)}},
    {"Pass",
     {{MEMBER(Pass, first_group), MEMBER(Pass, first_slot), MEMBER(Pass, group_count), MEMBER(Pass, paths),
       MEMBER(Pass, paths_before), MEMBER(Pass, first_set), MEMBER(Pass, sets), MEMBER(Pass, slots_per_pixel),
       MEMBER(Pass, packed_pixels), MEMBER(Pass, step_budget), MEMBER(Pass, resume), MEMBER(Pass, request_count)},
      sizeof(Pass)}},
    {"FilmSlot",
     {{MEMBER(FilmSlot, sum_r), MEMBER(FilmSlot, sum_g), MEMBER(FilmSlot, sum_b), MEMBER(FilmSlot, squares_a),
       MEMBER(FilmSlot, squares_b), MEMBER(FilmSlot, squares_c), MEMBER(FilmSlot, squares_d), MEMBER(FilmSlot, tail)},
      sizeof(FilmSlot)}},
    {"PathProfile",
     {{MEMBER(PathProfile, camera), MEMBER(PathProfile, scattered), MEMBER(PathProfile, shadow),
       MEMBER(PathProfile, shares)},
      sizeof(PathProfile)}},
    {"RejectedEntry",
     {{MEMBER(RejectedEntry, pixel), MEMBER(RejectedEntry, sample_index), MEMBER(RejectedEntry, segments),
       MEMBER(RejectedEntry, pad0)},
      sizeof(RejectedEntry)}},
    {"ReportHead",
     {{MEMBER(ReportHead, unfinished), MEMBER(ReportHead, stuck), MEMBER(ReportHead, rejected_count),
       MEMBER(ReportHead, pad0)},
      sizeof(ReportHead)}},
    {"SampleRequest",
     {{MEMBER(SampleRequest, pixel), MEMBER(SampleRequest, sample_index), MEMBER(SampleRequest, pad0),
       MEMBER(SampleRequest, pad1)},
      sizeof(SampleRequest)}},
    {"SampleResult",
     {{MEMBER(SampleResult, radiance), MEMBER(SampleResult, signature), MEMBER(SampleResult, segments),
       MEMBER(SampleResult, stuck), MEMBER(SampleResult, pad0), MEMBER(SampleResult, pad1)},
      sizeof(SampleResult)}},
    {"RayRequest",
     {{MEMBER(RayRequest, o), MEMBER(RayRequest, t_min), MEMBER(RayRequest, d), MEMBER(RayRequest, t_max)},
      sizeof(RayRequest)}},
    {"RayResult",
     {{MEMBER(RayResult, t), MEMBER(RayResult, instance), MEMBER(RayResult, primitive), MEMBER(RayResult, steps)},
      sizeof(RayResult)}},
    {"BsdfProbePass",
     {{MEMBER(BsdfProbePass, wo), MEMBER(BsdfProbePass, seed), MEMBER(BsdfProbePass, first),
       MEMBER(BsdfProbePass, count), MEMBER(BsdfProbePass, mode), MEMBER(BsdfProbePass, pad0)},
      sizeof(BsdfProbePass)}},
    {"BsdfProbeResult",
     {{MEMBER(BsdfProbeResult, wi), MEMBER(BsdfProbeResult, pdf), MEMBER(BsdfProbeResult, weight),
       MEMBER(BsdfProbeResult, lobe)},
      sizeof(BsdfProbeResult)}},
    {"TracedVertex",
     {{MEMBER(TracedVertex, radiance), MEMBER(TracedVertex, instance), MEMBER(TracedVertex, primitive),
       MEMBER(TracedVertex, light_instance), MEMBER(TracedVertex, light_primitive),
       MEMBER(TracedVertex, light_contributed), MEMBER(TracedVertex, lobe), MEMBER(TracedVertex, survived),
       MEMBER(TracedVertex, pad0), MEMBER(TracedVertex, pad1), MEMBER(TracedVertex, from), MEMBER(TracedVertex, pad2),
       MEMBER(TracedVertex, to), MEMBER(TracedVertex, pad3)},
      sizeof(TracedVertex)}},
};

std::vector<std::uint32_t> read_words(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  std::vector<std::uint32_t> words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), words.size() * 4);
  return words;
}

// Of one type: its name, the names of its members, their offsets, and the stride of arrays of it.
struct SpirvStruct {
  std::string name;
  std::map<std::uint32_t, std::string> members;
  std::map<std::uint32_t, std::uint32_t> offsets;
  std::set<std::uint32_t> strides;
};

// Ids of specialization constants by the names of the constants.
using Constants = std::map<std::string, std::set<std::uint32_t>>;

Constants parse_constants(const std::vector<std::uint32_t>& words) {
  constexpr std::uint32_t kName = 5, kDecorate = 71, kSpecId = 1;
  std::map<std::uint32_t, std::string> names;
  Constants constants;
  for (std::size_t i = 5; i < words.size() && words[i] >> 16 != 0; i += words[i] >> 16) {
    const std::uint32_t* w = words.data() + i;
    if ((w[0] & 0xffffu) == kName) names[w[1]] = reinterpret_cast<const char*>(w + 2);
    if ((w[0] & 0xffffu) == kDecorate && w[2] == kSpecId) constants[names[w[1]]].insert(w[3]);
  }
  return constants;
}

// The few instructions of the SPIR-V binary form that matter (specification, §3.42).
std::vector<SpirvStruct> parse_structs(const std::vector<std::uint32_t>& words) {
  constexpr std::uint32_t kName = 5, kMemberName = 6, kTypeArray = 28, kTypeRuntimeArray = 29, kDecorate = 71,
                          kMemberDecorate = 72;
  constexpr std::uint32_t kArrayStride = 6, kOffset = 35;
  std::map<std::uint32_t, SpirvStruct> types;
  std::map<std::uint32_t, std::uint32_t> strides;
  for (std::size_t i = 5; i < words.size() && words[i] >> 16 != 0; i += words[i] >> 16) {
    const std::uint32_t* w = words.data() + i;
    const auto text = [](const std::uint32_t* from) { return std::string(reinterpret_cast<const char*>(from)); };
    switch (w[0] & 0xffffu) {
      case kName:
        types[w[1]].name = text(w + 2);
        break;
      case kMemberName:
        types[w[1]].members[w[2]] = text(w + 3);
        break;
      case kDecorate:
        if (w[2] == kArrayStride) strides[w[1]] = w[3];
        break;
      case kMemberDecorate:
        if (w[3] == kOffset) types[w[1]].offsets[w[2]] = w[4];
        break;
      case kTypeArray:
      case kTypeRuntimeArray:
        if (strides.contains(w[1])) types[w[2]].strides.insert(strides[w[1]]);
        break;
      default:
        break;
    }
  }
  std::vector<SpirvStruct> out;
  for (auto& [id, type] : types) {
    if (!type.offsets.empty()) out.push_back(std::move(type));
  }
  return out;
}

// Checks every decorated struct of a binary that gpu_types.h names; returns those names.
std::set<std::string> check_binary(const std::filesystem::path& path) {
  std::set<std::string> seen;
  const auto words = read_words(path);
  EXPECT_GT(words.size(), 5u) << path;
  if (words.size() <= 5) return seen;
  EXPECT_EQ(words[0], 0x07230203u) << path << " is not SPIR-V";
  for (const SpirvStruct& s : parse_structs(words)) {
    const auto host = kHostLayouts.find(s.name);
    if (host == kHostLayouts.end()) continue;
    seen.insert(s.name);
    const Layout& layout = host->second;
    EXPECT_EQ(s.members.size(), layout.members.size()) << path << ": " << s.name;
    for (std::uint32_t i = 0; i < std::min(s.members.size(), layout.members.size()); ++i) {
      EXPECT_EQ(s.members.at(i), layout.members[i].name) << path << ": member " << i << " of " << s.name;
      EXPECT_EQ(s.offsets.at(i), layout.members[i].offset) << path << ": " << s.name << '.' << s.members.at(i);
    }
    for (const std::uint32_t stride : s.strides) EXPECT_EQ(stride, layout.size) << path << ": array of " << s.name;
  }
  return seen;
}

TEST(CompileLayout, EveryStructHasTheSameOffsetsInSpirvAndHere) {
  const std::set<std::string> seen = check_binary(LAYOUT_SPV);
  for (const auto& [name, layout] : kHostLayouts) {
    EXPECT_TRUE(seen.contains(name)) << name << " is in no buffer of tests/unit/kernels/layout.comp";
    EXPECT_EQ(layout.size % 16, 0u) << name;
  }
}

std::vector<std::filesystem::path> binaries_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> out;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".spv") out.push_back(entry.path());
  return out;
}

TEST(CompileLayout, TheRenderersKernelsAgree) {
  for (const char* folder : {KERNEL_DIR, MUTANT_DIR}) {
    const std::vector<std::filesystem::path> kernels = binaries_in(folder);
    EXPECT_GE(kernels.size(), 3u) << "in " << folder;
    for (const std::filesystem::path& kernel : kernels) EXPECT_TRUE(check_binary(kernel).contains("Frame")) << kernel;
  }
}

std::string read_header() {
  std::ifstream file(SHADER_DIR "/gpu_types.h");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// kConstant<X> = id in the header.
std::map<std::string, std::uint32_t> header_constants() {
  const std::string header = read_header();
  const std::regex declaration(R"(const uint kConstant(\w+) = (\d+)u;)");
  std::map<std::string, std::uint32_t> ids;
  for (std::sregex_iterator it(header.begin(), header.end(), declaration), end; it != end; ++it)
    ids[(*it)[1]] = static_cast<std::uint32_t>(std::stoul((*it)[2]));
  return ids;
}

TEST(CompileLayout, IdsOfSpecializationConstantsAreDistinct) {
  std::map<std::uint32_t, std::string> names;
  for (const auto& [name, id] : header_constants()) {
    EXPECT_TRUE(names.emplace(id, name).second) << name << " and " << names[id] << " have the same id " << id;
    EXPECT_TRUE(name == "Few" || id < kConstantFew) << name << " lies among the words of the few primitives";
  }
  EXPECT_GT(names.size(), 10u);
}

TEST(CompileLayout, SpecializationConstantsHaveTheIdsOfTheirNames) {
  std::map<std::string, std::uint32_t> unseen = header_constants();
  const std::map<std::string, std::uint32_t> ids = unseen;
  const std::regex few(R"(kFew(\d+)_(\d+))");
  std::vector<std::filesystem::path> kernels = binaries_in(KERNEL_DIR);
  std::ranges::copy(binaries_in(MUTANT_DIR), std::back_inserter(kernels));
  for (const std::filesystem::path& kernel : kernels) {
    for (const auto& [name, found] : parse_constants(read_words(kernel))) {
      SCOPED_TRACE(kernel.string() + ": " + name);
      ASSERT_EQ(found.size(), 1u) << "a constant without a name, or two of one name";
      std::smatch match;
      if (std::regex_match(name, match, few)) {
        const auto i = static_cast<std::uint32_t>(std::stoul(match[1])),
                   k = static_cast<std::uint32_t>(std::stoul(match[2]));
        ASSERT_TRUE(i < kFewPrimitives && k < kFewWords);
        EXPECT_EQ(*found.begin(), kConstantFew + kFewWords * i + k);
        unseen.erase("Few");
        continue;
      }
      ASSERT_TRUE(name.starts_with('k') && ids.contains(name.substr(1))) << "gpu_types.h has no kConstant… for it";
      EXPECT_EQ(*found.begin(), ids.at(name.substr(1)));
      unseen.erase(name.substr(1));
    }
  }
  for (const auto& [name, id] : unseen) ADD_FAILURE() << "no kernel has a constant k" << name << " with the id " << id;
}

TEST(CompileLayout, NoStructOfTheHeaderIsForgotten) {
  const std::string header = read_header();
  const std::regex declaration(R"(struct\s+(\w+)\s*\{)");
  std::size_t structs = 0;
  for (std::sregex_iterator it(header.begin(), header.end(), declaration), end; it != end; ++it, ++structs) {
    EXPECT_TRUE(kHostLayouts.contains((*it)[1]))
        << "add struct " << (*it)[1] << " to this test and to kernels/layout.comp";
  }
  EXPECT_GT(structs, 5u);
}

}  // namespace
}  // namespace etendue::gpu
