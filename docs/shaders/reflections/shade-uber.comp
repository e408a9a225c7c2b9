// A ray that missed on the screen is traced and shaded at once, by the shader of whatever it hits. Registers are counted here.
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
        default:
            // A layer of varnish over it.
            colour = shadeGlossy(base, more, surface.normal, unit, -direction);
            colour = (colour * 0.9 + shadeGlossy(vec4(0.0, 0.0, 0.0, 0.1), vec4(0.04), surface.normal, unit, -direction)) * visibility;
        }
    }
    pixels[first.w & 0xFFFFu] = vec4(colour, 1.0);
}
