// [two-level] instance: the ray from the world into the space of an instance's mesh, unless its mask hides the instance.
#include "shared.glsl"

// 128 bytes of an instance, of which this reads the first 64: BLAS, custom index and mask, flags; world to object; more.
layout(std430, binding = 0) readonly buffer Instances {
    vec4 instances[];
};

layout(location = 0) flat in vec3 origin;
layout(location = 1) flat in vec3 direction;
layout(location = 2) flat in uvec2 instance;
layout(location = 0) out vec3 objectOrigin;
layout(location = 1) out vec3 objectDirection;
layout(location = 2) out vec3 inverse;
layout(location = 3) out uint node;

void main() {
    uint first = 8u * instance.x;
    uvec4 head = floatBitsToUint(instances[first]);
    vec4 x = instances[first + 1u];
    vec4 y = instances[first + 2u];
    vec4 z = instances[first + 3u];
    Ray ray = makeRay(vec3(dot(x.xyz, origin) + x.w, dot(y.xyz, origin) + y.w, dot(z.xyz, origin) + z.w),
                      vec3(dot(x.xyz, direction), dot(y.xyz, direction), dot(z.xyz, direction)));
    objectOrigin = ray.origin;
    objectDirection = ray.direction;
    inverse = ray.inverse;
    node = (head.z >> 24 & instance.y) != 0u ? head.x : NONE;
}
