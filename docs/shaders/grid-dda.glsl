// Uniform grid by the 3D-DDA of Amanatides and Woo 1987.
//
// Cells of 16 bytes: first reference, reference count, unused.
#include "kd.glsl"

layout(std430, binding = 0) readonly buffer Cells {
    uvec4 cells[];
};

uniform vec3 cellWidth;
uniform vec3 cellsPerLength;
uniform ivec3 resolution;

bool trace(Ray ray, bool any, inout Hit hit) {
    vec2 span = slab(ray, sceneLow, sceneHigh, hit.t);
    if (span.x > span.y) {
        return false;
    }
    vec3 place = ray.origin + span.x * ray.direction;
    ivec3 coordinate = clamp(ivec3((place - sceneLow) * cellsPerLength), ivec3(0), resolution - 1);
    vec3 plane = sceneLow + vec3(coordinate + ivec3(not(ray.negative))) * cellWidth;
    vec3 next = (plane - ray.origin) * ray.inverse;
    vec3 delta = cellWidth * abs(ray.inverse);
    ivec3 stride = ivec3(1, resolution.x, resolution.x * resolution.y);
    int cell = coordinate.x + coordinate.y * stride.y + coordinate.z * stride.z;
    stride = mix(stride, -stride, ray.negative);
    // Where the ray leaves the current cell.
    float end = span.x;
    for (;;) {
        uvec4 record;
        do {
            if (hit.t <= end || end >= span.y) {
                return hit.triangle != NONE;
            }
            record = cells[cell];
            if (next.x < next.y && next.x < next.z) {
                end = next.x;
                next.x += delta.x;
                cell += stride.x;
            } else if (next.y < next.z) {
                end = next.y;
                next.y += delta.y;
                cell += stride.y;
            } else {
                end = next.z;
                next.z += delta.z;
                cell += stride.z;
            }
        } while (record.y == 0u);
        uint last = record.x + record.y;
        for (uint i = record.x; i < last; i++) {
            intersect(references[i], ray, hit);
            if (any && hit.triangle != NONE) {
                return true;
            }
        }
    }
}
