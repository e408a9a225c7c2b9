// [reflections] fetch: normal and texture coordinates of a hit.
precision highp float;
precision highp int;

#include "reflections/material.glsl"

flat in uvec4 mesh;
flat in vec3 hit;
layout(location = 0) out vec4 result;
layout(location = 1) out vec4 coordinate;

void main() {
    Surface surface = fetchSurface(mesh, floatBitsToUint(hit.z), hit.x, hit.y);
    result = vec4(surface.normal, surface.uv.x);
    coordinate = vec4(surface.uv.y);
}
