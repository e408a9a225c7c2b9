// [shared] shade: the normal of a hit, and the light that falls on it.
#include "shared.glsl"
#include "camera.glsl"

flat in vec4 hit;
flat in vec3 direction;
layout(location = 0) out vec4 result;

void main() {
    uint first = 6u * floatBitsToUint(hit.w);
    vec3 n0 = triangles[first + 3u].xyz;
    vec3 n1 = triangles[first + 4u].xyz;
    vec3 n2 = triangles[first + 5u].xyz;
    vec3 normal = hitNormal(n0, n1, n2, hit.y, hit.z);
    result = vec4(normal, max(dot(normal, normalize(direction)), 0.0));
}
