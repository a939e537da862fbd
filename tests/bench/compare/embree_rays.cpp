/// Casts the rays that `etendue bench --export` wrote through Embree: the same triangles and spheres, the same rays,
/// one at a time (rtcIntersect1, rtcOccluded1). Every answer is compared with Etendue's; rates go to stdout as JSON.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>

namespace {

struct Ray {
  float o[3], t_min, d[3], t_max;
};
struct RaySet {
  std::string kind;
  bool shuffled = false, any = false;
  std::vector<Ray> rays;
  std::vector<float> expected;  // distances by Etendue, infinite for no hit; 0 for any hit
};
struct Input {
  std::vector<float> triangles, spheres;  // 9 and 4 numbers each
  std::vector<RaySet> sets;
};
struct Options {
  std::string file;
  unsigned threads = 2;
  int repetitions = 3;
  RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM;  // Embree's default
};

class Reader {
 public:
  explicit Reader(const std::string& path) : file_(path, std::ios::binary) {
    if (!file_) throw std::runtime_error(path + ": cannot be read");
  }
  template <typename T>
  T value() {
    T v;
    bytes(&v, sizeof v);
    return v;
  }
  std::string text(std::size_t size) {
    std::string s(size, '\0');
    bytes(s.data(), size);
    return s.substr(0, s.find('\0'));
  }
  template <typename T>
  std::vector<T> array(std::size_t count) {
    std::vector<T> v(count);
    bytes(v.data(), count * sizeof(T));
    return v;
  }

 private:
  void bytes(void* to, std::size_t size) {
    if (!file_.read(static_cast<char*>(to), static_cast<std::streamsize>(size)))
      throw std::runtime_error("the file of rays ends too early");
  }
  std::ifstream file_;
};

// The format is in src/bench/export.h.
Input read_input(const std::string& path) {
  Reader in(path);
  if (in.text(8) != "ETDRAYS1") throw std::runtime_error(path + ": no file of etendue bench --export");
  const auto triangles = in.value<std::uint64_t>(), spheres = in.value<std::uint64_t>(),
             sets = in.value<std::uint64_t>();
  Input input;
  input.triangles = in.array<float>(9 * triangles);
  input.spheres = in.array<float>(4 * spheres);
  for (std::uint64_t i = 0; i < sets; ++i) {
    RaySet set;
    set.kind = in.text(16);
    set.shuffled = in.value<std::uint32_t>() != 0;
    set.any = in.value<std::uint32_t>() != 0;
    const auto count = in.value<std::uint64_t>();
    set.rays = in.array<Ray>(count);
    set.expected = in.array<float>(count);
    input.sets.push_back(std::move(set));
  }
  return input;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Of all threads together.
double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

class Scene {
 public:
  Scene(const Input& input, const Options& options)
      : device_(rtcNewDevice(fmt::format("threads={}", options.threads).c_str())) {
    if (device_ == nullptr) throw std::runtime_error("Embree cannot open a device");
    const auto start = std::chrono::steady_clock::now();
    scene_ = rtcNewScene(device_);
    rtcSetSceneBuildQuality(scene_, options.quality);
    if (!input.triangles.empty()) add_triangles(input.triangles, options.quality);
    if (!input.spheres.empty()) add_spheres(input.spheres);
    rtcCommitScene(scene_);
    build_seconds_ = seconds_since(start);
    if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) throw std::runtime_error("Embree could not build the scene");
  }
  ~Scene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  RTCScene get() const { return scene_; }
  double build_seconds() const { return build_seconds_; }

 private:
  void add_triangles(const std::vector<float>& vertices, RTCBuildQuality quality) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, quality);
    const std::size_t count = vertices.size() / 3;
    std::memcpy(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), count),
        vertices.data(), vertices.size() * sizeof(float));
    auto* index = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), count / 3));
    for (std::uint32_t i = 0; i < count; ++i) index[i] = i;
    attach(geometry);
  }
  void add_spheres(const std::vector<float>& spheres) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float),
                                        spheres.size() / 4),
                spheres.data(), spheres.size() * sizeof(float));
    attach(geometry);
  }
  void attach(RTCGeometry geometry) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }

  RTCDevice device_;
  RTCScene scene_ = nullptr;
  double build_seconds_ = 0;
};

// Embree 4 has no contexts.
#if RTC_VERSION_MAJOR >= 4
void intersect(RTCScene scene, RTCRayHit& query) {
  rtcIntersect1(scene, &query);
}
void occluded(RTCScene scene, RTCRay& ray) {
  rtcOccluded1(scene, &ray);
}
#else
void intersect(RTCScene scene, RTCRayHit& query) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
}
void occluded(RTCScene scene, RTCRay& ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
}
#endif

float cast_one(RTCScene scene, const Ray& ray, bool any) {
  RTCRayHit query{};
  query.ray.org_x = ray.o[0], query.ray.org_y = ray.o[1], query.ray.org_z = ray.o[2], query.ray.tnear = ray.t_min;
  query.ray.dir_x = ray.d[0], query.ray.dir_y = ray.d[1], query.ray.dir_z = ray.d[2], query.ray.tfar = ray.t_max;
  query.ray.mask = 0xffffffffu;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  constexpr float kNoHit = std::numeric_limits<float>::infinity();
  if (any) {
    occluded(scene, query.ray);
    return query.ray.tfar < 0.0f ? 0.0f : kNoHit;
  }
  intersect(scene, query);
  return query.hit.geomID != RTC_INVALID_GEOMETRY_ID ? query.ray.tfar : kNoHit;
}

// Threads take rays in chunks, in order.
double cast_all(RTCScene scene, const RaySet& set, unsigned threads, std::vector<float>& answers) {
  constexpr std::size_t kChunk = 4096;
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t begin = next.fetch_add(kChunk); begin < set.rays.size(); begin = next.fetch_add(kChunk)) {
      const std::size_t end = std::min(begin + kChunk, set.rays.size());
      for (std::size_t i = begin; i < end; ++i) answers[i] = cast_one(scene, set.rays[i], set.any);
    }
  };
  const auto start = std::chrono::steady_clock::now();
  {
    std::vector<std::jthread> workers;
    for (unsigned i = 1; i < threads; ++i) workers.emplace_back(work);
    work();
  }
  return seconds_since(start);
}

struct Agreement {
  std::size_t hits = 0, differ = 0;
};

// Distances that differ by more than 0.1 % are other hits.
Agreement compare(const RaySet& set, const std::vector<float>& answers) {
  Agreement out;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const bool hit = std::isfinite(answers[i]);
    out.hits += hit;
    out.differ += hit != std::isfinite(set.expected[i]) ||
                  (hit && std::abs(answers[i] - set.expected[i]) > 1e-3f * std::max(0.01f, set.expected[i]));
  }
  return out;
}

std::string measure(const Scene& scene, const RaySet& set, const Options& options) {
  std::vector<float> answers(set.rays.size());
  cast_all(scene.get(), set, options.threads, answers);  // warms up
  std::string rates, cpu_rates;
  for (int i = 0; i < options.repetitions; ++i) {
    double seconds = 0.0, rays = 0.0;
    const double cpu_start = cpu_seconds();
    while (seconds < 0.05) {
      seconds += cast_all(scene.get(), set, options.threads, answers);
      rays += static_cast<double>(set.rays.size());
    }
    rates += fmt::format("{}{:.6g}", i > 0 ? ", " : "", rays / seconds);
    cpu_rates += fmt::format("{}{:.6g}", i > 0 ? ", " : "", rays / (cpu_seconds() - cpu_start));
  }
  const Agreement agreement = compare(set, answers);
  return fmt::format(R"({{"class": "{}", "order": "{}", "rays": {}, "hits": {}, "differ": {}, )"
                     R"("rays_per_second": [{}], "rays_per_cpu_second": [{}]}})",
                     set.kind, set.shuffled ? "shuffled" : "picture", set.rays.size(), agreement.hits, agreement.differ,
                     rates, cpu_rates);
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--threads" && i + 1 < argc) {
      options.threads = static_cast<unsigned>(std::max(1, std::atoi(argv[++i])));
    } else if (word == "--repetitions" && i + 1 < argc) {
      options.repetitions = std::max(1, std::atoi(argv[++i]));
    } else if (word == "--high") {
      options.quality = RTC_BUILD_QUALITY_HIGH;  // spatial splits
    } else if (options.file.empty() && !word.starts_with("-")) {
      options.file = word;
    } else {
      options.file.clear();
      break;
    }
  }
  if (options.file.empty())
    throw std::runtime_error("usage: embree_rays [--threads N] [--repetitions N] [--high] rays.bin");
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = parse(argc, argv);
    const Input input = read_input(options.file);
    const Scene scene(input, options);
    std::string sets;
    for (const RaySet& set : input.sets) sets += (sets.empty() ? "\n  " : ",\n  ") + measure(scene, set, options);
    fmt::print(
        "{{\"embree\": \"{}\", \"quality\": \"{}\", \"threads\": {}, \"build_seconds\": {:.6g}, \"rays\": [{}\n]}}\n",
        RTC_VERSION_STRING, options.quality == RTC_BUILD_QUALITY_HIGH ? "high" : "medium", options.threads,
        scene.build_seconds(), sets);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "embree_rays: {}\n", error.what());
    return 1;
  }
}
