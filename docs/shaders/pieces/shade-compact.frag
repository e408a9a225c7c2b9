// [shared] compact_normal: as shade, where the first normal lies in the padding of the vertices.
#include "shared.glsl"
#include "camera.glsl"

flat in vec4 hit;
flat in vec3 direction;
layout(location = 0) out vec4 result;

void main() {
    uint first = 5u * floatBitsToUint(hit.w);
    vec3 n0 = vec3(triangles[first].w, triangles[first + 1u].w, triangles[first + 2u].w);
    vec3 n1 = triangles[first + 3u].xyz;
    vec3 n2 = triangles[first + 4u].xyz;
    vec3 normal = hitNormal(n0, n1, n2, hit.y, hit.z);
    result = vec4(normal, max(dot(normal, normalize(direction)), 0.0));
}
