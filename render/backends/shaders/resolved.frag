// The image as it is read: light encoded as sRGB, times alpha, and depth in metres, 0 for none. What
// is seen through lies over the rest.

layout(location = 0) out vec4 image;
layout(location = 1) out float depth_m;
uniform sampler2D light;
uniform sampler2DMS depths;
uniform vec2 near_and_fall;
#ifdef BLENDED
uniform sampler2D before;
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 seen = texelFetch(light, pixel, 0);
#ifdef BLENDED
    vec4 front = texelFetch(before, pixel, 0);
    seen = front + (1.0 - front.a) * seen;
#endif
    vec3 own = clamp(seen.rgb / max(seen.a, 1e-6), 0.0, 1.0);
    vec3 bright = 1.055 * pow(own, vec3(1.0 / 2.4)) - 0.055;
    own = mix(bright, 12.92 * own, lessThanEqual(own, vec3(0.0031308)));
    // White is rounded to the same byte as its alpha.
    image = vec4(min(own * seen.a + 1e-5, seen.a), seen.a);
    // 1 - d has no rounding; a projection matrix is undone in one division.
    float stored = texelFetch(depths, pixel, 0).r;
    float fall = near_and_fall.y;
    depth_m = stored == 1.0 ? 0.0 : near_and_fall.x * (1.0 + fall) / (1.0 - stored + fall);
}
