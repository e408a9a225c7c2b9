// Nodes of 256 bytes: lower planes of eight children in x, y and z, upper planes, references. A child that is not there has an empty box.
layout(std430, binding = 0) readonly buffer Nodes {
    vec4 nodes[];
};

#define WIDTH 8
#define HALF(first, i) { \
    vec4 lowX = nodes[16u * node + first]; vec4 lowY = nodes[16u * node + 2u + first]; vec4 lowZ = nodes[16u * node + 4u + first]; \
    vec4 highX = nodes[16u * node + 6u + first]; vec4 highY = nodes[16u * node + 8u + first]; vec4 highZ = nodes[16u * node + 10u + first]; \
    uvec4 links = floatBitsToUint(nodes[16u * node + 12u + first]); uvec4 counts = floatBitsToUint(nodes[16u * node + 14u + first]); \
    CHILD(i, x) CHILD(i + 1, y) CHILD(i + 2, z) CHILD(i + 3, w) }
#define CHILD(i, c) distances[i] = enter(ray, vec3(lowX.c, lowY.c, lowZ.c), vec3(highX.c, highY.c, highZ.c), hit.t); \
    children[i] = links.c | counts.c << 24;
#define READ_NODE HALF(0u, 0) HALF(1u, 4)
#include "wide.glsl"
