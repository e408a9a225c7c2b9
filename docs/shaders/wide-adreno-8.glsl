// Nodes of 64 bytes as Adreno 7xx has them (Mesa, tu_bvh.h): first child; upper halves of the origin; per child lower x, y, z and upper x, y, z in
// a byte each; exponents, child count, and a bit per child that is a leaf. Children follow each other, and a leaf is one triangle.
layout(std430, binding = 0) readonly buffer Nodes {
    uvec4 nodes[];
};

#define WIDTH 8
#define WORD(w) ((w) < 4 ? a : (w) < 8 ? b : (w) < 12 ? c : d)[(w) & 3]
#define BYTE(at) float(WORD((at) / 4) >> (8 * ((at) & 3)) & 0xFFu)
#define CHILD(i) { \
    vec3 low = origin + step * vec3(BYTE(10 + 6 * i), BYTE(11 + 6 * i), BYTE(12 + 6 * i)); \
    vec3 high = origin + step * vec3(BYTE(13 + 6 * i), BYTE(14 + 6 * i), BYTE(15 + 6 * i)); \
    children[i] = a.x + uint(i) | ((d.w >> (16 + i) & 1u) != 0u ? 0x81000000u : 0u); \
    distances[i] = uint(i) < (d.w >> 8 & 0xFFu) ? enter(ray, low, high, hit.t) : MISSED; }
#define READ_NODE { \
    uvec4 a = nodes[4u * node]; uvec4 b = nodes[4u * node + 1u]; uvec4 c = nodes[4u * node + 2u]; uvec4 d = nodes[4u * node + 3u]; \
    vec3 origin = uintBitsToFloat(uvec3(a.y << 16, a.y & 0xFFFF0000u, a.z << 16)); \
    vec3 step = uintBitsToFloat(uvec3(d.z << 7 & 0x7F800000u, d.z >> 1 & 0x7F800000u, d.w << 23 & 0x7F800000u)); \
    CHILD(0) CHILD(1) CHILD(2) CHILD(3) CHILD(4) CHILD(5) CHILD(6) CHILD(7) }
#include "wide.glsl"
