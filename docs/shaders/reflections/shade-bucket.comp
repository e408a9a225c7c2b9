// The hits of one shader: attributes, a shadow ray by ray query, the material. Registers are counted here.
#include "shared.glsl"
#include "ray-query.glsl"

layout(local_size_x = 64) in;

#include "camera.glsl"
#include "reflections/material.glsl"

layout(std430, binding = 6) readonly buffer Bucket {
    uint size;
    uint end;
    uint order[];
};

layout(std430, binding = 7) readonly buffer HitInstances {
    uint instances[];
};

layout(std430, binding = 10) readonly buffer HitRecords {
    uint records[];
};

layout(std430, binding = 11) readonly buffer Positions {
    float positions[];
};

layout(std430, binding = 16) writeonly buffer Image {
    vec4 pixels[];
};

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= size) {
        return;
    }
    uint element = order[end - 1u - index];
    uvec4 mesh = meshes[instances[element]];
    uint pixel = records[5u * element + 1u];
    float u = uintBitsToFloat(records[5u * element + 2u]);
    float v = uintBitsToFloat(records[5u * element + 3u]);
    Surface surface = fetchSurface(mesh, records[5u * element + 4u], u, v);
    vec3 point = vec3(positions[3u * element], positions[3u * element + 1u], positions[3u * element + 2u]);
    vec3 toViewer = normalize(eye - point);
    vec3 origin = shadowOrigin(point, surface.normal, -toViewer);
    vec3 toLight = light - origin;
    Hit blocker = Hit(1.0, 0.0, 0.0, NONE);
    float visibility = trace(makeRay(origin, toLight), true, blocker) ? 0.0 : 1.0;
    vec4 base = materials[2u * mesh.w];
    vec4 more = materials[2u * mesh.w + 1u];
    vec3 colour = shadeGlossy(base, more, surface.normal, normalize(toLight), toViewer);
    pixels[pixel] = vec4(more.xyz + visibility * colour, 1.0);
}
