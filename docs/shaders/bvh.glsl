// BVH nodes of 32 bytes: box minimum, reference; box maximum, unused. Siblings follow each other.
//
// The reference of an inner node is the index of its left child. That of a leaf has bit 31 set, the number of its triangles in the
// next 7 bits, and the first of them in the rest.
layout(std430, binding = 0) readonly buffer Nodes {
    vec4 nodes[];
};

// A leaf that is none: the end of the search.
const uint END = NONE;

bool isLeaf(uint reference) {
    return int(reference) < 0;
}
