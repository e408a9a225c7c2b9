// kd-tree nodes of 16 bytes: split, axis (3 for a leaf), left child or first reference, right child or reference count.
layout(std430, binding = 0) readonly buffer Nodes {
    uvec4 nodes[];
};

const uint LEAF = 3u;
