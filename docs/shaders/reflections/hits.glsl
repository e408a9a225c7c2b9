// Records around the tracing of rays that missed on the screen.

// 32 bytes: origin and pixel; direction and probability density.
layout(std430, binding = 5) readonly buffer Failed {
    uvec4 failed[];
};

layout(std430, binding = 6) buffer Hits {
    uint total;
    uint instances[];
};

// 20 bytes: density, pixel; barycentric coordinates and triangle of a hit, or the direction of a miss.
layout(std430, binding = 10) buffer HitRecords {
    uint records[];
};

layout(std430, binding = 11) buffer Positions {
    float positions[];
};

void writeHit(uint index, bool found, Hit hit, vec3 origin, vec3 direction, uint pixel, uint density) {
    instances[index] = found ? hit.triangle >> 16 : 0xFFFFFFFFu;
    records[5u * index] = density;
    records[5u * index + 1u] = pixel;
    records[5u * index + 2u] = floatBitsToUint(found ? hit.u : direction.x);
    records[5u * index + 3u] = floatBitsToUint(found ? hit.v : direction.y);
    records[5u * index + 4u] = found ? hit.triangle : floatBitsToUint(direction.z);
    vec3 position = origin + direction * hit.t;
    positions[3u * index] = position.x;
    positions[3u * index + 1u] = position.y;
    positions[3u * index + 2u] = position.z;
}
