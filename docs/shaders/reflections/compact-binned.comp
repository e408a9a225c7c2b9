// Rays that missed on the screen, put into bins by each workgroup and appended with one atomic for all.
precision highp float;
precision highp int;

layout(local_size_x = 8, local_size_y = 8) in;

#include "reflections/records.glsl"

// No constant, so that the compiler keeps the loops.
uniform uint bins;

shared uint counts[64];
shared uint groupStart;

void main() {
    uint lane = gl_LocalInvocationIndex;
    for (uint bin = lane; bin < bins; bin += 64u) {
        counts[bin] = 0u;
    }
    barrier();
    vec4 origin = rays[2u * lane];
    vec4 direction = rays[2u * lane + 1u];
    bool misses = direction.w > 0.0;
    uint bin = floatBitsToUint(origin.w);
    uint rank = 0u;
    if (misses) {
        rank = atomicAdd(counts[bin], 1u);
    }
    barrier();
    if (lane == 0u) {
        uint sum = 0u;
        for (uint b = 0u; b < bins; ++b) {
            sum += counts[b];
        }
        uint start = atomicAdd(total, sum);
        groupStart = start;
        atomicMax(groups, (start + sum + GROUP - 1u) / GROUP);
    }
    barrier();
    if (misses) {
        uint place = groupStart + rank;
        for (uint b = 0u; b < bin; ++b) {
            place += counts[b];
        }
        writeFailed(place, origin.xyz, direction.xyz, gl_GlobalInvocationID.xy, direction.w);
    }
}
