/* Trace a scan through Embree's C API, ray by ray or in packets of 16: compiled and called by `benches/peers.py`.

   The structures are those of Embree 4's reference manual. Each ray is copied into them, and what is hit back out. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#define WIDTH 16
/* A hit ends with one or two lists of instances, by how the library was built: there is room for both. */
#define NUM_INSTANCE_LISTS 2

typedef struct {
    float org[3], tnear, dir[3], time, tfar;
    unsigned mask, id, flags;
    float normal[3], uv[2];
    unsigned primitive, geometry, instance[NUM_INSTANCE_LISTS];
} __attribute__((aligned(16))) RayHit;

typedef struct {
    float org[3][WIDTH], tnear[WIDTH], dir[3][WIDTH], time[WIDTH], tfar[WIDTH];
    unsigned mask[WIDTH], id[WIDTH], flags[WIDTH];
    float normal[3][WIDTH], uv[2][WIDTH];
    unsigned primitive[WIDTH], geometry[WIDTH], instance[NUM_INSTANCE_LISTS][WIDTH];
} __attribute__((aligned(64))) RayHit16;

typedef struct {
    int flags, feature_mask;
    void *context, *filter, *intersect;
} Arguments;

typedef void (*Intersect1)(void *scene, RayHit *, Arguments *);
typedef void (*Intersect16)(const int *valid, void *scene, RayHit16 *, Arguments *);

/* `origins` and `directions` hold three floats a ray; `ranges` and `primitives` get one number each. */
void trace_single(Intersect1 intersect, void *scene, int flags, size_t count, const float *origins,
                  const float *directions, float *ranges, unsigned *primitives) {
    Arguments arguments = {.flags = flags, .feature_mask = -1};
    for (size_t i = 0; i < count; i++) {
        RayHit ray;
        memset(&ray, 0, sizeof ray);
        memcpy(ray.org, origins + 3 * i, sizeof ray.org);
        memcpy(ray.dir, directions + 3 * i, sizeof ray.dir);
        ray.tfar = INFINITY;
        ray.mask = ray.primitive = ray.geometry = ray.instance[0] = ~0u;
        intersect(scene, &ray, &arguments);
        ranges[i] = ray.tfar;
        primitives[i] = ray.primitive;
    }
}

/* The same in packets of neighbors; the last one may be part empty. */
void trace_packets(Intersect16 intersect, void *scene, int flags, size_t count, const float *origins,
                   const float *directions, float *ranges, unsigned *primitives) {
    Arguments arguments = {.flags = flags, .feature_mask = -1};
    for (size_t start = 0; start < count; start += WIDTH) {
        size_t size = count - start < WIDTH ? count - start : WIDTH;
        int valid[WIDTH] __attribute__((aligned(64)));
        RayHit16 rays;
        memset(&rays, 0, sizeof rays);
        for (size_t k = 0; k < WIDTH; k++) {
            valid[k] = k < size ? -1 : 0;
            size_t i = start + (k < size ? k : 0);
            for (size_t axis = 0; axis < 3; axis++) {
                rays.org[axis][k] = origins[3 * i + axis];
                rays.dir[axis][k] = directions[3 * i + axis];
            }
            rays.tfar[k] = INFINITY;
            rays.mask[k] = rays.primitive[k] = rays.geometry[k] = rays.instance[0][k] = ~0u;
        }
        intersect(valid, scene, &rays, &arguments);
        memcpy(ranges + start, rays.tfar, size * sizeof *ranges);
        memcpy(primitives + start, rays.primitive, size * sizeof *primitives);
    }
}
