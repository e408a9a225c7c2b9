// [shared] unproject: the position of a rasterised hit, from its depth.
precision highp float;

uniform mat4 inverseTransform;
uniform vec2 pixelSize;

flat in float depth;
out vec3 result;

void main() {
    vec3 clip = vec3(gl_FragCoord.xy * pixelSize, depth) * 2.0 - 1.0;
    // The standalone compiler does not know products of matrix and vector.
    vec4 position = inverseTransform[0] * clip.x + inverseTransform[1] * clip.y + inverseTransform[2] * clip.z + inverseTransform[3];
    result = position.xyz / position.w;
}
