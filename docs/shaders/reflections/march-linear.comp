// A ray marched on the screen in equal steps (McGuire and Mara 2014, without the search that refines the hit).
precision highp float;
precision highp int;

layout(local_size_x = 8, local_size_y = 8) in;

#include "reflections/screen.glsl"

void main() {
    uint index = gl_LocalInvocationIndex;
    vec4 origin = rays[2u * index];
    vec4 direction = rays[2u * index + 1u];
    Line line = screenLine(origin.xyz, direction.xyz, origin.w);
    float count = max(abs(line.delta.x), abs(line.delta.y)) * line.end * perStride;
    vec3 pace = line.delta * (line.end / max(count, 1.0));
    vec3 position = line.start;
    float hit = -1.0;
    for (float step = 0.0; step < count; step += 1.0) {
        position += pace;
        float surface = depths[uint(position.y) * width + uint(position.x)];
        if (position.z < surface && position.z > surface * thickness) {
            hit = step;
            break;
        }
    }
    rays[2u * index] = vec4(position, hit);
}
