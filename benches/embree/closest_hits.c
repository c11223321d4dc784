/* Closest hits by Embree 4, for benches/embree.rs: closest_hits LIBRARY.
 *
 * Says "1" once it has the library. Then a line of stdin is a command, and a line of stdout its answer:
 *
 *   mesh FILE   two 32-bit counts, vertices (3 floats each), triangles (3 indices each); answer: seconds to build
 *   rays FILE   a 32-bit count, then origin and direction of each ray (6 floats); answer: the count
 *   run         answer: seconds for all rays, one after the other, and the number of hits
 *
 * The declarations are those of Embree 4's public interface: no headers are needed, and the library is loaded as it
 * comes in a Python wheel.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef void *handle;

/* struct RTCRayHit, and room for the fields that later versions add. */
struct __attribute__((aligned(16))) ray_hit {
    float origin[3], tnear, direction[3], time, tfar;
    uint32_t mask, id, flags;
    float normal[3], u, v;
    uint32_t primitive, geometry, instances[8];
};

enum { TRIANGLES = 0, INDICES = 0, VERTICES = 1, UINT3 = 0x5003, FLOAT3 = 0x9003, ROBUST = 1 << 2 };

static handle (*new_device)(const char *);
static handle (*new_scene)(handle);
static void (*set_scene_flags)(handle, int);
static handle (*new_geometry)(handle, int);
static void *(*new_buffer)(handle, int, unsigned, int, size_t, size_t);
static void (*commit_geometry)(handle);
static unsigned (*attach_geometry)(handle, handle);
static void (*release_geometry)(handle);
static void (*commit_scene)(handle);
static void (*release_scene)(handle);
static void (*intersect)(handle, struct ray_hit *, void *);

static void fail(const char *what) {
    fprintf(stderr, "closest_hits: %s\n", what);
    exit(1);
}

static void *symbol(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) fail(name);
    return found;
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void read_exactly(void *to, size_t size, FILE *file) {
    if (fread(to, 1, size, file) != size) fail("a file is too short");
}

static double build(handle device, handle *scene, FILE *file) {
    uint32_t counts[2];
    read_exactly(counts, sizeof counts, file);
    if (*scene) release_scene(*scene);
    *scene = new_scene(device);
    set_scene_flags(*scene, ROBUST);
    handle geometry = new_geometry(device, TRIANGLES);
    read_exactly(new_buffer(geometry, VERTICES, 0, FLOAT3, 12, counts[0]), 12 * (size_t)counts[0], file);
    read_exactly(new_buffer(geometry, INDICES, 0, UINT3, 12, counts[1]), 12 * (size_t)counts[1], file);
    double start = now();
    commit_geometry(geometry);
    attach_geometry(*scene, geometry);
    release_geometry(geometry);
    commit_scene(*scene);
    return now() - start;
}

int main(int count, char **arguments) {
    if (count != 2) fail("usage: closest_hits LIBRARY");
    void *library = dlopen(arguments[1], RTLD_NOW);
    if (!library) fail(dlerror());
    *(void **)&new_device = symbol(library, "rtcNewDevice");
    *(void **)&new_scene = symbol(library, "rtcNewScene");
    *(void **)&set_scene_flags = symbol(library, "rtcSetSceneFlags");
    *(void **)&new_geometry = symbol(library, "rtcNewGeometry");
    *(void **)&new_buffer = symbol(library, "rtcSetNewGeometryBuffer");
    *(void **)&commit_geometry = symbol(library, "rtcCommitGeometry");
    *(void **)&attach_geometry = symbol(library, "rtcAttachGeometry");
    *(void **)&release_geometry = symbol(library, "rtcReleaseGeometry");
    *(void **)&commit_scene = symbol(library, "rtcCommitScene");
    *(void **)&release_scene = symbol(library, "rtcReleaseScene");
    *(void **)&intersect = symbol(library, "rtcIntersect1");
    handle device = new_device(NULL), scene = NULL;
    if (!device) fail("no device");
    puts("1");
    fflush(stdout);
    float(*rays)[6] = NULL;
    uint32_t ray_count = 0;
    char line[4096];
    while (fgets(line, sizeof line, stdin)) {
        line[strcspn(line, "\n")] = 0;
        if (!strcmp(line, "run")) {
            uint32_t hits = 0;
            double start = now();
            for (uint32_t i = 0; i < ray_count; i++) {
                struct ray_hit it;
                memcpy(it.origin, rays[i], 12);
                memcpy(it.direction, rays[i] + 3, 12);
                it.tnear = 0, it.time = 0, it.tfar = INFINITY;
                it.mask = ~0u, it.id = 0, it.flags = 0;
                it.geometry = it.primitive = it.instances[0] = ~0u;
                intersect(scene, &it, NULL);
                hits += it.geometry != ~0u;
            }
            printf("%.9f %u\n", now() - start, hits);
        } else {
            FILE *file = strlen(line) > 5 ? fopen(line + 5, "rb") : NULL;
            if (!file) fail(line);
            if (!strncmp(line, "mesh ", 5)) {
                printf("%.9f\n", build(device, &scene, file));
            } else if (!strncmp(line, "rays ", 5)) {
                read_exactly(&ray_count, 4, file);
                rays = realloc(rays, 24 * (size_t)ray_count);
                if (!rays) fail("no memory");
                read_exactly(rays, 24 * (size_t)ray_count, file);
                printf("%u\n", ray_count);
            } else {
                fail(line);
            }
            fclose(file);
        }
        fflush(stdout);
    }
    return 0;
}
