// BVH by restart trail (Laine 2010), with a short stack of SHORT_STACK entries or none.
#include "bvh.glsl"

const uint FINISHED = 0x80000000u;

uint root;
uint trail;
// The bit of the decision that led to the current node, and the bit that the last pop set.
uint above;
uint popped;

#if SHORT_STACK > 0
// A ring of the latest far children.
uvec2 stack[SHORT_STACK];
uint depth;
uint kept;
#endif

uint pop(float end) {
    for (;;) {
        trail = (trail & -above) + above;
        if (trail >= FINISHED) {
            return END;
        }
        popped = trail & -trail;
#if SHORT_STACK > 0
        if (kept > 0u) {
            kept--;
            depth--;
            above = popped;
            uvec2 entry = stack[depth % uint(SHORT_STACK)];
            if (uintBitsToFloat(entry.y) <= end) {
                return entry.x;
            }
            continue;
        }
        depth = 0u;
#endif
        above = FINISHED;
        return root;
    }
}

bool trace(Ray ray, bool any, inout Hit hit) {
    vec4 low = nodes[0];
    vec4 high = nodes[1];
    vec2 span = slab(ray, low.xyz, high.xyz, hit.t);
    if (span.x > span.y) {
        return false;
    }
    root = floatBitsToUint(low.w);
    uint node = root;
    trail = 0u;
    above = FINISHED;
    popped = 0u;
#if SHORT_STACK > 0
    depth = 0u;
    kept = 0u;
#endif
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
            uint level = above >> 1;
            if (hitA && hitB) {
                bool leftFirst = a.x <= b.x;
                uint farther = leftFirst ? right : left;
                above = level;
                if ((trail & level) != 0u) {
                    node = farther;
                } else {
                    node = leftFirst ? left : right;
#if SHORT_STACK > 0
                    stack[depth % uint(SHORT_STACK)] = uvec2(farther, floatBitsToUint(leftFirst ? b.x : a.x));
                    depth++;
                    kept = min(kept + 1u, uint(SHORT_STACK));
#endif
                }
            } else if ((hitA || hitB) && level != popped) {
                trail |= level;
                above = level;
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
