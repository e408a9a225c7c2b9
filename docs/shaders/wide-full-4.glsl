// Nodes of 128 bytes: lower planes of four children in x, y and z, upper planes, references. A child that is not there has an empty box.
layout(std430, binding = 0) readonly buffer Nodes {
    vec4 nodes[];
};

#define WIDTH 4
#define READ_NODE { \
    vec4 lowX = nodes[8u * node]; vec4 lowY = nodes[8u * node + 1u]; vec4 lowZ = nodes[8u * node + 2u]; \
    vec4 highX = nodes[8u * node + 3u]; vec4 highY = nodes[8u * node + 4u]; vec4 highZ = nodes[8u * node + 5u]; \
    uvec4 links = floatBitsToUint(nodes[8u * node + 6u]); uvec4 counts = floatBitsToUint(nodes[8u * node + 7u]); \
    CHILD(0, x) CHILD(1, y) CHILD(2, z) CHILD(3, w) }
#define CHILD(i, c) distances[i] = enter(ray, vec3(lowX.c, lowY.c, lowZ.c), vec3(highX.c, highY.c, highZ.c), hit.t); \
    children[i] = links.c | counts.c << 24;
#include "wide.glsl"
