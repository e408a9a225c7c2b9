// A ray that missed on the screen is traced and shaded at once, by the shader of whatever it hits: a switch over ENTRIES materials.
#include "shared.glsl"
#include "ray-query.glsl"

layout(local_size_x = 64) in;

#include "camera.glsl"
#include "reflections/material.glsl"

layout(std430, binding = 5) readonly buffer Failed {
    uvec4 failed[];
};

layout(std430, binding = 6) readonly buffer Count {
    uint total;
};

layout(std430, binding = 16) writeonly buffer Image {
    vec4 pixels[];
};

vec3 varnish(vec4 base, vec4 more, vec3 normal, vec3 toLight, vec3 toViewer) {
    vec3 below = shadeGlossy(base, more, normal, toLight, toViewer);
    return below * 0.9 + shadeGlossy(vec4(0.0, 0.0, 0.0, 0.1), vec4(0.04), normal, toLight, toViewer);
}

vec4 squares(vec4 base, vec4 more, vec2 uv) {
    return fract(uv.x) < 0.5 == fract(uv.y) < 0.5 ? base : vec4(more.xyz, base.w);
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= total) {
        return;
    }
    uvec4 first = failed[2u * index];
    uvec4 second = failed[2u * index + 1u];
    vec3 start = uintBitsToFloat(first.xyz);
    vec3 direction = uintBitsToFloat(second.xyz);
    Hit hit = Hit(1e30, 0.0, 0.0, NONE);
    vec3 colour = direction;
    if (trace(makeRay(start, direction), false, hit)) {
        uvec4 mesh = meshes[hit.triangle >> 16];
        Surface surface = fetchSurface(mesh, hit.triangle & 0xFFFFu, hit.u, hit.v);
        vec3 origin = shadowOrigin(hitPoint(start, direction, hit.t), surface.normal, direction);
        vec3 toLight = light - origin;
        Hit blocker = Hit(1.0, 0.0, 0.0, NONE);
        float visibility = trace(makeRay(origin, toLight), true, blocker) ? 0.0 : 1.0;
        vec4 base = materials[2u * mesh.w];
        vec4 more = materials[2u * mesh.w + 1u];
        vec3 unit = normalize(toLight);
        switch (mesh.z) {
        case 0u:
            colour = shadeDiffuse(base, surface.normal, unit) * visibility;
            break;
        case 1u:
            colour = shadeGlossy(base, more, surface.normal, unit, -direction) * visibility;
            break;
        case 2u:
            colour = more.xyz;
            break;
#if ENTRIES == 8
        // The same four, with a second albedo in squares.
        case 4u:
            colour = shadeDiffuse(squares(base, more, surface.uv), surface.normal, unit) * visibility;
            break;
        case 5u:
            colour = shadeGlossy(squares(base, more, surface.uv), more, surface.normal, unit, -direction) * visibility;
            break;
        case 6u:
            colour = squares(base, more, surface.uv).xyz;
            break;
        case 7u:
            colour = varnish(squares(base, more, surface.uv), more, surface.normal, unit, -direction) * visibility;
            break;
#endif
        default:
            colour = varnish(base, more, surface.normal, unit, -direction) * visibility;
        }
    }
    pixels[first.w & 0xFFFFu] = vec4(colour, 1.0);
}
