// A ray marched through a pyramid of largest depths, cell by cell (Uludag 2014): up after a cell that it crosses above the surface, down
// where it may meet it.
precision highp float;
precision highp int;

layout(local_size_x = 8, local_size_y = 8) in;

#include "reflections/screen.glsl"

uniform float mostSteps;
// Where the levels of the pyramid begin.
uniform uint levelStart[12];

void main() {
    uint index = gl_LocalInvocationIndex;
    vec4 origin = rays[2u * index];
    vec4 direction = rays[2u * index + 1u];
    Line line = screenLine(origin.xyz, direction.xyz, origin.w);
    vec3 inverse = 1.0 / line.delta;
    vec3 scaled = line.start * inverse;
    // A cell's far corner, and a way past it.
    vec2 corner = vec2(line.delta.x > 0.0 ? 1.0 : 0.0, line.delta.y > 0.0 ? 1.0 : 0.0);
    vec2 past = vec2(line.delta.x > 0.0 ? 0.005 : -0.005, line.delta.y > 0.0 ? 0.005 : -0.005);
    float t = 0.0;
    int level = 0;
    // Cells per pixel, and pixels per cell.
    float cells = 1.0;
    float edge = 1.0;
    vec3 position = line.start;
    for (float step = 0.0; step < mostSteps && level >= 0 && t < line.end; step += 1.0) {
        vec2 cell = floor(position.xy * cells);
        float surface = depths[levelStart[level] + uint(cell.y) * (width >> uint(level)) + uint(cell.x)];
        vec2 planes = (cell + corner) * edge + past;
        vec2 side = planes * inverse.xy - scaled.xy;
        float reached = line.delta.z > 0.0 ? surface * inverse.z - scaled.z : 1e30;
        float next = min(min(side.x, side.y), reached);
        bool above = position.z > surface;
        bool skipped = above && next != reached;
        t = above ? next : t;
        position = line.start + line.delta * t;
        level += skipped ? 1 : -1;
        cells *= skipped ? 0.5 : 2.0;
        edge *= skipped ? 2.0 : 0.5;
    }
    rays[2u * index] = vec4(position, level < 0 ? 1.0 : 0.0);
}
