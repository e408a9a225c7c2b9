// Nodes of 80 bytes after Ylitie, Karras and Laine 2017: origin, three exponents and which children are inner; first inner child, first triangle, and a byte
// per child (of an inner child its place, of a leaf its number of triangles and, in the upper five bits, how far behind the first triangle it begins;
// 0 for none); lower planes of eight children in x, y, z, upper planes, a byte each.
layout(std430, binding = 0) readonly buffer Nodes {
    uvec4 nodes[];
};

#define WIDTH 8
#define BYTE(words, i) float((i < 4 ? words.x : words.y) >> (8 * (i & 3)) & 0xFFu)
#define CHILD(i) { \
    vec3 low = origin + step * vec3(BYTE(lowX, i), BYTE(lowY, i), BYTE(lowZ, i)); \
    vec3 high = origin + step * vec3(BYTE(highX, i), BYTE(highY, i), BYTE(highZ, i)); \
    uint meta = (i < 4 ? head.z : head.w) >> (8 * (i & 3)) & 0xFFu; \
    bool inner = (first.w >> (24 + i) & 1u) != 0u; \
    children[i] = inner ? head.x + meta : (head.y + (meta >> 3)) | (meta & 7u) << 24 | 0x80000000u; \
    distances[i] = inner || meta != 0u ? enter(ray, low, high, hit.t) : MISSED; }
#define READ_NODE { \
    uvec4 first = nodes[5u * node]; uvec4 head = nodes[5u * node + 1u]; \
    uvec4 a = nodes[5u * node + 2u]; uvec4 b = nodes[5u * node + 3u]; uvec4 c = nodes[5u * node + 4u]; \
    uvec2 lowX = a.xy; uvec2 lowY = a.zw; uvec2 lowZ = b.xy; uvec2 highX = b.zw; uvec2 highY = c.xy; uvec2 highZ = c.zw; \
    vec3 origin = uintBitsToFloat(first.xyz); \
    vec3 step = uintBitsToFloat(uvec3(first.w << 23 & 0x7F800000u, first.w << 15 & 0x7F800000u, first.w << 7 & 0x7F800000u)); \
    CHILD(0) CHILD(1) CHILD(2) CHILD(3) CHILD(4) CHILD(5) CHILD(6) CHILD(7) }
#include "wide.glsl"
