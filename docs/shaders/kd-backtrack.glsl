// kd-backtrack (Foley and Sugerman 2005): after a leaf the search climbs to the first ancestor that the ray leaves later.
//
// Nodes of 48 bytes: cell minimum, split; cell maximum, parent (the root has none); left child, right child, axis (3 for a leaf) in
// the two low bits and the reference count above, first reference.
#include "kd.glsl"

layout(std430, binding = 0) readonly buffer Nodes {
    vec4 nodes[];
};

const uint LEAF = 3u;

bool trace(Ray ray, bool any, inout Hit hit) {
    vec2 span = slab(ray, sceneLow, sceneHigh, hit.t);
    if (span.x > span.y) {
        return false;
    }
    uint node = 0u;
    for (;;) {
        uint parent;
        uvec4 links;
        for (;;) {
            float split = nodes[3u * node].w;
            parent = floatBitsToUint(nodes[3u * node + 1u].w);
            links = floatBitsToUint(nodes[3u * node + 2u]);
            uint axis = links.z & 3u;
            if (axis == LEAF) {
                break;
            }
            float t = (split - ray.origin[axis]) * ray.inverse[axis];
            bool rightFirst = ray.direction[axis] < 0.0;
            uint near = rightFirst ? links.y : links.x;
            uint far = rightFirst ? links.x : links.y;
            if (t >= span.y) {
                node = near;
            } else if (t <= span.x) {
                node = far;
            } else {
                node = near;
                span.y = t;
            }
        }
        uint last = links.w + (links.z >> 2);
        for (uint i = links.w; i < last; i++) {
            intersect(references[i], ray, hit);
            if (any && hit.triangle != NONE) {
                return true;
            }
        }
        if (hit.t <= span.y) {
            return hit.triangle != NONE;
        }
        span.x = span.y;
        do {
            if (parent == NONE) {
                return hit.triangle != NONE;
            }
            vec4 low = nodes[3u * parent];
            vec4 high = nodes[3u * parent + 1u];
            links = floatBitsToUint(nodes[3u * parent + 2u]);
            vec3 exit = (mix(high.xyz, low.xyz, ray.negative) - ray.origin) * ray.inverse;
            span.y = min(min(exit.x, exit.y), exit.z);
            parent = floatBitsToUint(high.w);
        } while (span.y <= span.x);
        // The ray left the near child, through the split plane.
        node = ray.direction[links.z & 3u] < 0.0 ? links.x : links.y;
    }
}
