// A ray marched through a pyramid of least distances, cell by cell (Uludag 2014): up after a cell that it crosses before the surface, down
// where it may be behind it.
precision highp float;
precision highp int;

layout(local_size_x = 8, local_size_y = 8) in;

#include "reflections/screen.glsl"

uniform float mostSteps;
uniform uint top;
// Past the border of a cell.
uniform float nudge;
// Where the levels of the pyramid begin.
uniform uint levelStart[12];

// Two to the power of a small number.
float power(uint exponent) {
    return uintBitsToFloat(exponent + 127u << 23);
}

void main() {
    uint index = gl_LocalInvocationIndex;
    vec4 origin = rays[2u * index];
    vec4 direction = rays[2u * index + 1u];
    Line line = screenLine(origin.xyz, direction.xyz, origin.w);
    vec3 inverse = 1.0 / line.delta;
    vec3 scaled = line.start * inverse;
    // A cell's border ahead.
    vec2 ahead = vec2(line.delta.x > 0.0 ? 1.0 : 0.0, line.delta.y > 0.0 ? 1.0 : 0.0);
    vec2 first = (floor(line.start.xy) + ahead) * inverse.xy - scaled.xy;
    float t = min(first.x, first.y);
    float free = 0.0;
    bool allFree = true;
    bool hit = false;
    uint level = 0u;
    for (float step = 0.0; step < mostSteps && t + nudge < line.end; step += 1.0) {
        float edge = power(level);
        vec2 cell = floor((line.start.xy + line.delta.xy * (t + nudge)) * power(-level));
        vec2 sides = (cell + ahead) * edge * inverse.xy - scaled.xy;
        float leaves = min(min(sides.x, sides.y), line.end);
        uint place = uint(cell.y) * (width >> level) + uint(cell.x);
        float surface = depths[levelStart[level] + place];
        float here = line.start.z + line.delta.z * t;
        float there = line.start.z + line.delta.z * leaves;
        if (min(here, there) > surface) {
            t = leaves;
            free = allFree ? t : free;
            level = min(level + 1u, top);
        } else if (level > 0u) {
            float reached = surface * inverse.z - scaled.z;
            t = here > surface && reached > t && reached < leaves ? reached : t;
            free = allFree ? t : free;
            level -= 1u;
        } else {
            bool near = max(here, there) > surface * thickness;
            if (!near || faces(place, direction.xyz)) {
                hit = near;
                break;
            }
            allFree = false;
            t = leaves;
        }
    }
    rays[2u * index] = vec4(line.start + line.delta * t, hit ? 1.0 : -free);
}
