// Only depth is kept, of pixels that show a part of a mesh in any of their samples: what lights it is
// then drawn nowhere else. (Drivers that draw on the processor skip pixels before a shader, not in it.)

uniform usampler2DMS covered;
uniform uint first;
uniform uint stop;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 ids = uvec4(texelFetch(covered, pixel, 0).r, texelFetch(covered, pixel, 1).r,
                      texelFetch(covered, pixel, 2).r, texelFetch(covered, pixel, 3).r);
    if (!any(lessThan(ids - first, uvec4(stop - first)))) {
        discard;
    }
}
