// A ray marched on the screen in equal steps (McGuire and Mara 2014). A texel of the search for the first hit of a stride would cost what a step does.
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
    float free = 0.0;
    bool allFree = true;
    bool hit = false;
    for (float step = 1.0; step < count; step += 1.0) {
        float before = position.z;
        position += pace;
        uint pixel = uint(position.y) * width + uint(position.x);
        float surface = depths[pixel];
        if (min(before, position.z) < surface) {
            bool near = max(before, position.z) > surface * thickness;
            if (!near || faces(pixel, direction.xyz)) {
                hit = near;
                break;
            }
            allFree = false;
        }
        free = allFree ? step : free;
    }
    rays[2u * index] = vec4(position, hit ? 1.0 : -free);
}
