// [shared] shadow_ray: from a hit to the light.
#include "shared.glsl"
#include "camera.glsl"

layout(location = 0) flat in vec4 direction;
layout(location = 1) flat in vec3 normal;
layout(location = 0) out vec3 origin;
layout(location = 1) out vec3 toLight;

void main() {
    origin = shadowOrigin(hitPoint(eye, direction.xyz, direction.w), normal, direction.xyz);
    toLight = light - origin;
}
