// BVH with a full stack. An entry is a reference and the distance at which the ray enters its box.
#include "bvh.glsl"

uvec2 stack[64];
uint top;

uint pop(float end) {
    while (top > 0u) {
        top--;
        uvec2 entry = stack[top];
        if (uintBitsToFloat(entry.y) <= end) {
            return entry.x;
        }
    }
    return END;
}

bool trace(Ray ray, bool any, inout Hit hit) {
    vec4 low = nodes[0];
    vec4 high = nodes[1];
    vec2 span = slab(ray, low.xyz, high.xyz, hit.t);
    if (span.x > span.y) {
        return false;
    }
    uint node = floatBitsToUint(low.w);
    top = 0u;
    for (;;) {
        while (!isLeaf(node)) {
            vec4 lowA = nodes[2u * node];
            vec4 highA = nodes[2u * node + 1u];
            vec4 lowB = nodes[2u * node + 2u];
            vec4 highB = nodes[2u * node + 3u];
            vec2 a = slab(ray, lowA.xyz, highA.xyz, hit.t);
            vec2 b = slab(ray, lowB.xyz, highB.xyz, hit.t);
            bool hitA = a.x <= a.y;
            bool hitB = b.x <= b.y;
            uint left = floatBitsToUint(lowA.w);
            uint right = floatBitsToUint(lowB.w);
            if (hitA && hitB) {
                bool leftFirst = a.x <= b.x;
                stack[top] = leftFirst ? uvec2(right, floatBitsToUint(b.x)) : uvec2(left, floatBitsToUint(a.x));
                top++;
                node = leftFirst ? left : right;
            } else if (hitA || hitB) {
                node = hitA ? left : right;
            } else {
                node = pop(hit.t);
            }
        }
        if (node == END) {
            return hit.triangle != NONE;
        }
        uint triangle = node & 0xFFFFFFu;
        uint last = triangle + (node >> 24 & 0x7Fu);
        for (; triangle < last; triangle++) {
            intersect(triangle, ray, hit);
            if (any && hit.triangle != NONE) {
                return true;
            }
        }
        node = pop(hit.t);
    }
}
