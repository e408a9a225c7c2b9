// BVH by parent links (Hapala et al. 2011).
//
// Nodes of 48 bytes: box minimum, left child; box maximum, right child; parent, first triangle, triangle count, axes. An inner node
// has no triangles. Axes: the node's own in the two low bits, its parent's in the next two. Siblings follow each other, the left one
// at an odd index.
layout(std430, binding = 0) readonly buffer Nodes {
    vec4 nodes[];
};

const uint FROM_PARENT = 0u;
const uint FROM_SIBLING = 1u;
const uint FROM_CHILD = 2u;

uint sibling(uint node) {
    return ((node - 1u) ^ 1u) + 1u;
}

bool trace(Ray ray, bool any, inout Hit hit) {
    uint node = 0u;
    // The root has no sibling to go to.
    uint from = FROM_SIBLING;
    for (;;) {
        uint triangle = 0u;
        uint last = 0u;
        while (last == 0u) {
            if (from == FROM_CHILD) {
                if (node == 0u) {
                    return hit.triangle != NONE;
                }
                uvec4 links = floatBitsToUint(nodes[3u * node + 2u]);
                bool rightFirst = ray.direction[links.w >> 2] < 0.0;
                bool isRight = (node & 1u) == 0u;
                if (isRight == rightFirst) {
                    node = sibling(node);
                    from = FROM_SIBLING;
                } else {
                    node = links.x;
                }
            } else {
                vec4 low = nodes[3u * node];
                vec4 high = nodes[3u * node + 1u];
                uvec4 links = floatBitsToUint(nodes[3u * node + 2u]);
                vec2 span = slab(ray, low.xyz, high.xyz, hit.t);
                bool isHit = span.x <= span.y;
                if (isHit && links.z == 0u) {
                    bool rightFirst = ray.direction[links.w & 3u] < 0.0;
                    node = floatBitsToUint(rightFirst ? high.w : low.w);
                    from = FROM_PARENT;
                } else {
                    if (isHit) {
                        triangle = links.y;
                        last = triangle + links.z;
                    }
                    if (from == FROM_PARENT) {
                        node = sibling(node);
                        from = FROM_SIBLING;
                    } else {
                        node = links.x;
                        from = FROM_CHILD;
                    }
                }
            }
        }
        for (; triangle < last; triangle++) {
            intersect(triangle, ray, hit);
            if (any && hit.triangle != NONE) {
                return true;
            }
        }
    }
}
