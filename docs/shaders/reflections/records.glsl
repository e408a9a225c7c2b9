// Records between the passes.

const uint GROUP = 64u;

layout(std430, binding = 3) buffer Rays {
    vec4 rays[];
};

layout(std430, binding = 4) buffer Counters {
    uint total;
    uint groups;
};

// Rays that missed on the screen, 32 bytes each: origin and pixel; direction and probability density.
layout(std430, binding = 5) buffer Failed {
    uvec4 failed[];
};

void writeFailed(uint place, vec3 origin, vec3 direction, uvec2 pixel, float density) {
    failed[2u * place] = uvec4(floatBitsToUint(origin), pixel.x | pixel.y << 16);
    failed[2u * place + 1u] = floatBitsToUint(vec4(direction, density));
}
