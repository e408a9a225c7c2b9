// A ray that missed on the screen is traced by a ray query, its hit or direction written for later.
precision highp int;

#include "shared.glsl"
#include "ray-query.glsl"

layout(local_size_x = 64) in;

#include "reflections/hits.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < total) {
        uvec4 first = failed[2u * index];
        uvec4 second = failed[2u * index + 1u];
        vec3 origin = uintBitsToFloat(first.xyz);
        vec3 direction = uintBitsToFloat(second.xyz);
        Hit hit = Hit(1e30, 0.0, 0.0, NONE);
        bool found = trace(makeRay(origin, direction), false, hit);
        writeHit(index, found, hit, origin, direction, first.w, second.w);
    }
}
