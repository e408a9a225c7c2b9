// One traversal alone: a ray in, its nearest hit out. Steps are counted here.
#include "shared.glsl"
#include TRAVERSAL

layout(local_size_x = 8, local_size_y = 8) in;

// Origin; direction and longest distance. The hit takes the place of the origin.
layout(std430, binding = 3) buffer Rays {
    vec4 rays[];
};

void main() {
    uint index = gl_LocalInvocationIndex;
    vec4 origin = rays[2u * index];
    vec4 direction = rays[2u * index + 1u];
    Hit hit = Hit(direction.w, 0.0, 0.0, NONE);
    trace(makeRay(origin.xyz, direction.xyz), false, hit);
    rays[2u * index] = vec4(hit.t, hit.u, hit.v, uintBitsToFloat(hit.triangle));
}
