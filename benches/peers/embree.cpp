// Embree on the scene and the rays that `trace --peer` exports; compare.py drives it.
//
//   embree LIBRARY FOLDER QUALITY ROBUST
//
// LIBRARY is the shared library of Embree 4. QUALITY is 0 low, 1 medium, 2 high; ROBUST 0 or 1. Standard input names a
// family, how it goes (`1` ray by ray, `16` in packets, `16c` in packets said to be coherent) and perhaps `check`, a line
// each: `primary 16c check`. For each line a line of JSON is printed; after `check` the answers stand in FOLDER. One thread;
// processor time.
//
// Rays are filled in 4,096 at a time outside of the clock and traced inside, as our side does. The declarations below are
// Embree 4's documented interface, written down here so that no headers need to be installed.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <dlfcn.h>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace {

struct alignas(16) Ray {
    float org[3], tnear, dir[3], time, tfar;
    uint32_t mask, id, flags;
};
// One word more than some versions have: the library writes what it knows of.
struct alignas(16) Hit {
    float normal[3], u, v;
    uint32_t primitive, geometry, instance, instance_primitive;
};
struct RayHit {
    Ray ray;
    Hit hit;
};
struct alignas(64) Ray16 {
    float org[3][16], tnear[16], dir[3][16], time[16], tfar[16];
    uint32_t mask[16], id[16], flags[16];
};
struct alignas(64) Hit16 {
    float normal[3][16], u[16], v[16];
    uint32_t primitive[16], geometry[16], instance[16], instance_primitive[16];
};
struct RayHit16 {
    Ray16 ray;
    Hit16 hit;
};
struct Arguments {
    int flags;
    unsigned features;
    void* context;
    void* filter;
    void* callback;
    float min_width;
};

using Device = void*;
using Scene = void*;
using Geometry = void*;

constexpr int TRIANGLE = 0, INSTANCE = 121, INDEX_BUFFER = 0, VERTEX_BUFFER = 1;
constexpr int UINT3 = 0x5003, FLOAT3 = 0x9003, FLOAT3X4_COLUMNS = 0x9234;
constexpr int COHERENT = 1 << 16, ROBUST_SCENE = 1 << 2;
constexpr unsigned TRIANGLES_AND_INSTANCES = 1u << 1 | 1u << 23, NOTHING = ~0u;

struct Library {
    void* handle;
    Device (*new_device)(const char*);
    ptrdiff_t (*property)(Device, int);
    int (*error)(Device);
    void (*monitor)(Device, bool (*)(void*, ptrdiff_t, bool), void*);
    Scene (*new_scene)(Device);
    void (*scene_quality)(Scene, int);
    void (*scene_flags)(Scene, int);
    void (*commit_scene)(Scene);
    Geometry (*new_geometry)(Device, int);
    void (*shared_buffer)(Geometry, int, unsigned, int, const void*, size_t, size_t, size_t);
    void (*instanced)(Geometry, Scene);
    void (*transform)(Geometry, unsigned, int, const void*);
    void (*commit_geometry)(Geometry);
    unsigned (*attach)(Scene, Geometry);
    void (*release)(Geometry);
    void (*intersect1)(Scene, RayHit*, Arguments*);
    void (*occluded1)(Scene, Ray*, Arguments*);
    void (*intersect16)(const int*, Scene, RayHit16*, Arguments*);
    void (*occluded16)(const int*, Scene, Ray16*, Arguments*);

    template <class F>
    void find(F& function, const char* name) {
        function = reinterpret_cast<F>(dlsym(handle, name));
        if (!function) {
            std::fprintf(stderr, "embree: the library has no `%s`; Embree 4 is needed\n", name);
            std::exit(2);
        }
    }

    explicit Library(const char* path) : handle(dlopen(path, RTLD_NOW)) {
        if (!handle) {
            std::fprintf(stderr, "embree: %s\n", dlerror());
            std::exit(2);
        }
        find(new_device, "rtcNewDevice");
        find(property, "rtcGetDeviceProperty");
        find(error, "rtcGetDeviceError");
        find(monitor, "rtcSetDeviceMemoryMonitorFunction");
        find(new_scene, "rtcNewScene");
        find(scene_quality, "rtcSetSceneBuildQuality");
        find(scene_flags, "rtcSetSceneFlags");
        find(commit_scene, "rtcCommitScene");
        find(new_geometry, "rtcNewGeometry");
        find(shared_buffer, "rtcSetSharedGeometryBuffer");
        find(instanced, "rtcSetGeometryInstancedScene");
        find(transform, "rtcSetGeometryTransform");
        find(commit_geometry, "rtcCommitGeometry");
        find(attach, "rtcAttachGeometry");
        find(release, "rtcReleaseGeometry");
        find(intersect1, "rtcIntersect1");
        find(occluded1, "rtcOccluded1");
        find(intersect16, "rtcIntersect16");
        find(occluded16, "rtcOccluded16");
    }
};

// The numbers of an array of NumPy's format 1.0, four bytes each, with `padding` more after them.
template <class T>
std::vector<T> read_array(const std::string& path, size_t padding = 0) {
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    const auto size = static_cast<size_t>(in.tellg());
    char start[10];
    in.seekg(0);
    in.read(start, 10);
    uint16_t header;
    std::memcpy(&header, start + 8, 2);
    if (!in || std::memcmp(start, "\x93NUMPY\x01", 7) != 0) {
        std::fprintf(stderr, "embree: `%s` is no array of NumPy's format 1.0\n", path.c_str());
        std::exit(2);
    }
    const size_t count = (size - 10 - header) / sizeof(T);
    std::vector<T> values(count + padding);
    in.seekg(10 + header);
    in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)));
    return values;
}

double seconds(clockid_t clock) {
    timespec t;
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

ptrdiff_t held_bytes = 0, peak_bytes = 0;

bool count_bytes(void*, ptrdiff_t bytes, bool) {
    held_bytes += bytes;
    peak_bytes = std::max(peak_bytes, held_bytes);
    return true;
}

struct World {
    std::vector<float> vertices, transforms;
    std::vector<uint32_t> triangles, ranges, meshes;
    Scene scene;
    double build_s;

    // Meshes that stand where they are become geometry of the top level; the others are instanced.
    World(const Library& lib, Device device, const std::string& folder, int quality, bool robust)
        // Embree reads 16 bytes at a time.
        : vertices(read_array<float>(folder + "/vertices.npy", 4)),
          transforms(read_array<float>(folder + "/transforms.npy")),
          triangles(read_array<uint32_t>(folder + "/triangles.npy")),
          ranges(read_array<uint32_t>(folder + "/ranges.npy")),
          meshes(read_array<uint32_t>(folder + "/meshes.npy")) {
        const double begun = seconds(CLOCK_PROCESS_CPUTIME_ID);
        const auto new_scene = [&] {
            Scene made = lib.new_scene(device);
            lib.scene_quality(made, quality);
            lib.scene_flags(made, robust ? ROBUST_SCENE : 0);
            return made;
        };
        const auto add_mesh = [&](Scene into, uint32_t mesh) {
            const uint32_t* r = &ranges[4 * mesh];
            Geometry g = lib.new_geometry(device, TRIANGLE);
            lib.shared_buffer(g, VERTEX_BUFFER, 0, FLOAT3, vertices.data(), size_t(r[0]) * 12, 12, r[1]);
            lib.shared_buffer(g, INDEX_BUFFER, 0, UINT3, triangles.data(), size_t(r[2]) * 12, 12, r[3]);
            lib.commit_geometry(g);
            lib.attach(into, g);
            lib.release(g);
        };
        scene = new_scene();
        std::vector<Scene> instanced(ranges.size() / 4, nullptr);
        const float identity[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
        for (size_t i = 0; i < meshes.size(); i++) {
            const uint32_t mesh = meshes[i];
            const float* columns = &transforms[12 * i];
            if (std::equal(identity, identity + 12, columns)) {
                add_mesh(scene, mesh);
                continue;
            }
            if (!instanced[mesh]) {
                instanced[mesh] = new_scene();
                add_mesh(instanced[mesh], mesh);
                lib.commit_scene(instanced[mesh]);
            }
            Geometry g = lib.new_geometry(device, INSTANCE);
            lib.instanced(g, instanced[mesh]);
            lib.transform(g, 0, FLOAT3X4_COLUMNS, columns);
            lib.commit_geometry(g);
            lib.attach(scene, g);
            lib.release(g);
        }
        lib.commit_scene(scene);
        build_s = seconds(CLOCK_PROCESS_CPUTIME_ID) - begun;
    }
};

struct Result {
    size_t met = 0;
    double cpu_s = 0;
};

constexpr size_t BATCH = 4096;

// Traces rays (eight floats each) and gives the distance of what each meets; where anything is asked for at all, 0.
Result trace(const Library& lib, Scene scene, const std::vector<float>& rays, bool closest, size_t width,
             bool coherent, std::vector<float>& answers) {
    const size_t count = rays.size() / 8;
    const float none = std::numeric_limits<float>::infinity();
    answers.resize(count);
    Result result;
    Arguments arguments{coherent ? COHERENT : 0, TRIANGLES_AND_INSTANCES, nullptr, nullptr, nullptr, 0};
    std::vector<RayHit> single(BATCH);
    std::vector<Ray> single_any(BATCH);
    std::vector<RayHit16> packets(BATCH / 16);
    alignas(64) int valid[16];
    for (size_t first = 0; first < count; first += BATCH) {
        const size_t size = std::min(BATCH, count - first);
        for (size_t i = 0; i < size; i++) {
            const float* r = &rays[8 * (first + i)];
            if (width == 1) {
                const Ray ray{{r[0], r[1], r[2]}, r[3], {r[4], r[5], r[6]}, 0, r[7], NOTHING, 0, 0};
                if (closest) {
                    single[i].ray = ray;
                    single[i].hit.geometry = single[i].hit.instance = NOTHING;
                } else {
                    single_any[i] = ray;
                }
                continue;
            }
            Ray16& p = packets[i / 16].ray;
            Hit16& h = packets[i / 16].hit;
            const size_t lane = i % 16;
            for (int k = 0; k < 3; k++) {
                p.org[k][lane] = r[k];
                p.dir[k][lane] = r[4 + k];
            }
            p.tnear[lane] = r[3];
            p.tfar[lane] = r[7];
            p.time[lane] = 0;
            p.mask[lane] = NOTHING;
            p.id[lane] = p.flags[lane] = 0;
            h.geometry[lane] = h.instance[lane] = NOTHING;
        }
        const double begun = seconds(CLOCK_THREAD_CPUTIME_ID);
        if (width == 1 && closest) {
            for (size_t i = 0; i < size; i++) lib.intersect1(scene, &single[i], &arguments);
        } else if (width == 1) {
            for (size_t i = 0; i < size; i++) lib.occluded1(scene, &single_any[i], &arguments);
        } else {
            for (size_t i = 0; i < size; i += 16) {
                for (size_t lane = 0; lane < 16; lane++) valid[lane] = i + lane < size ? -1 : 0;
                if (closest) {
                    lib.intersect16(valid, scene, &packets[i / 16], &arguments);
                } else {
                    lib.occluded16(valid, scene, &packets[i / 16].ray, &arguments);
                }
            }
        }
        result.cpu_s += seconds(CLOCK_THREAD_CPUTIME_ID) - begun;
        for (size_t i = 0; i < size; i++) {
            const RayHit16& p = packets[i / 16];
            float t;
            if (closest) {
                const bool hit = (width == 1 ? single[i].hit.geometry : p.hit.geometry[i % 16]) != NOTHING;
                t = hit ? (width == 1 ? single[i].ray.tfar : p.ray.tfar[i % 16]) : none;
            } else {
                // An occluded ray's end is minus infinity.
                t = (width == 1 ? single_any[i].tfar : p.ray.tfar[i % 16]) < 0 ? 0 : none;
            }
            answers[first + i] = t;
            result.met += t < none;
        }
    }
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 5) {
        std::fprintf(stderr, "usage: embree LIBRARY FOLDER QUALITY ROBUST\n");
        return 2;
    }
    const Library lib(argv[1]);
    const std::string folder = argv[2];
    Device device = lib.new_device("threads=1,set_affinity=0");
    lib.monitor(device, count_bytes, nullptr);
    const World world(lib, device, folder, std::atoi(argv[3]), std::atoi(argv[4]) != 0);
    if (const int error = lib.error(device)) {
        std::fprintf(stderr, "embree: error %d\n", error);
        return 1;
    }
    std::printf("{\"version\": %td, \"native16\": %td, \"cpu_s\": %.4f, \"tree_bytes\": %td, \"peak_bytes\": %td}\n",
                lib.property(device, 0), lib.property(device, 34), world.build_s, held_bytes, peak_bytes);
    std::fflush(stdout);
    std::string line, loaded;
    std::vector<float> rays, answers;
    while (std::getline(std::cin, line)) {
        std::istringstream words(line);
        std::string family, way, check;
        words >> family >> way >> check;
        const bool closest = std::ifstream(folder + "/" + family + "-closest.npy").good();
        if (family != loaded) {
            rays = read_array<float>(folder + "/" + family + (closest ? "-closest.npy" : "-any.npy"));
            loaded = family;
        }
        const Result result = trace(lib, world.scene, rays, closest, way == "1" ? 1 : 16, way == "16c", answers);
        if (check == "check") {
            std::ofstream out(folder + "/" + family + "-embree.f32", std::ios::binary);
            out.write(reinterpret_cast<const char*>(answers.data()),
                      static_cast<std::streamsize>(answers.size() * sizeof(float)));
        }
        std::printf("{\"rays\": %zu, \"met\": %zu, \"cpu_s\": %.6f}\n", rays.size() / 8, result.met, result.cpu_s);
        std::fflush(stdout);
    }
}
