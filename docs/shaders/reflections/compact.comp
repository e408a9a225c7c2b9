// Rays that missed on the screen, appended with an atomic each.
precision highp float;
precision highp int;

layout(local_size_x = 8, local_size_y = 8) in;

#include "reflections/records.glsl"

void main() {
    vec4 origin = rays[2u * gl_LocalInvocationIndex];
    vec4 direction = rays[2u * gl_LocalInvocationIndex + 1u];
    if (direction.w > 0.0) {
        uint place = atomicAdd(total, 1u);
        atomicMax(groups, (place + GROUP) / GROUP);
        writeFailed(place, origin.xyz, direction.xyz, gl_GlobalInvocationID.xy, direction.w);
    }
}
