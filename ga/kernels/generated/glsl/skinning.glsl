/*
 * Kernels of the group skinning: carry_motor, carry_dual_quaternion, carry_similarity,
 * carry_matrix.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those.
 */

/*
 * carry_motor: A point and a normal carried by a sum of motors
 * m: 1, e23, e31, e12, e1inf, e2inf, e3inf, e123inf
 * x: x, y, z
 * n: x, y, z
 * out: x, y, z, nx, ny, nz
 */
void carry_motor(float m[8], float x[3], float n[3], out float out_out[6])
{
    float m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3], m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    float x0 = x[0], x1 = x[1], x2 = x[2];
    float n0 = n[0], n1 = n[1], n2 = n[2];
    float t0 = m0 * x0 + m3 * x1 - m2 * x2;
    float t1 = m0 * x1 + x2 * m1 - x0 * m3;
    float t2 = m0 * x2 + x0 * m2 - x1 * m1;
    float t3 = m3 * x2 + x0 * m1 + x1 * m2;
    float t4 = m0 * t0 + m3 * t1 - m2 * t2 + m1 * t3 + -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 *
        m7);
    float t5 = 1.0 / (m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1);
    float t6 = m0 * t1 - m3 * t0 + m2 * t3 + m1 * t2 + -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 *
        m6);
    float t7 = m2 * t0 - m1 * t1 + m0 * t2 + m3 * t3 + -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 *
        m7);
    float t8 = m0 * n0 + m3 * n1 - m2 * n2;
    float t9 = m0 * n1 + m1 * n2 - m3 * n0;
    float t10 = m0 * n2 + m2 * n0 - m1 * n1;
    float t11 = m3 * n2 + m1 * n0 + m2 * n1;
    out_out[0] = t4 * t5;
    out_out[1] = t5 * t6;
    out_out[2] = t5 * t7;
    out_out[3] = t5 * (m0 * t8 + m3 * t9 - m2 * t10 + m1 * t11);
    out_out[4] = t5 * (m0 * t9 - m3 * t8 + m2 * t11 + m1 * t10);
    out_out[5] = t5 * (m2 * t8 - m1 * t9 + m0 * t10 + m3 * t11);
}

/*
 * carry_dual_quaternion: A point and a normal carried by a sum of dual quaternions, real wxyz,
 *     dual wxyz
 * q: w, x, y, z, eps w, eps x, eps y, eps z
 * x: x, y, z
 * n: x, y, z
 * out: x, y, z, nx, ny, nz
 */
void carry_dual_quaternion(float q[8], float x[3], float n[3], out float out_out[6])
{
    float q0 = q[0], q1 = q[1], q2 = q[2], q3 = q[3], q4 = q[4], q5 = q[5], q6 = q[6], q7 = q[7];
    float x0 = x[0], x1 = x[1], x2 = x[2];
    float n0 = n[0], n1 = n[1], n2 = n[2];
    float t0 = 2.0 / (q0 * q0 + (q1 * q1 + q2 * q2 + q3 * q3));
    float t1 = q1 * x1 - x0 * q2 + q0 * x2;
    float t2 = x0 * q3 - q1 * x2 + q0 * x1;
    float t3 = q2 * x2 - q3 * x1 + x0 * q0;
    float t4 = q1 * n1 - q2 * n0 + q0 * n2;
    float t5 = q3 * n0 - q1 * n2 + q0 * n1;
    float t6 = q2 * n2 - q3 * n1 + q0 * n0;
    out_out[0] = x0 + t0 * (q2 * t1 - q3 * t2) + t0 * (q0 * q5 - q1 * q4 + (q2 * q7 - q3 * q6));
    out_out[1] = x1 + t0 * (q3 * t3 - q1 * t1) + t0 * (q0 * q6 - q2 * q4 + (q3 * q5 - q1 * q7));
    out_out[2] = x2 + t0 * (q1 * t2 - q2 * t3) + t0 * (q0 * q7 - q3 * q4 + (q1 * q6 - q2 * q5));
    out_out[3] = n0 + t0 * (q2 * t4 - q3 * t5);
    out_out[4] = n1 + t0 * (q3 * t6 - q1 * t4);
    out_out[5] = n2 + t0 * (q1 * t5 - q2 * t6);
}

/*
 * carry_similarity: A point and a normal carried by a sum of similarities
 * s: 1, e23, e31, e12, E, e23E, e31E, e12E, e1inf, e2inf, e3inf, e123inf
 * x: x, y, z
 * n: x, y, z
 * out: x, y, z, nx, ny, nz
 */
void carry_similarity(float s[12], float x[3], float n[3], out float out_out[6])
{
    float s0 = s[0], s1 = s[1], s2 = s[2], s3 = s[3], s4 = s[4], s5 = s[5], s6 = s[6], s7 = s[7], s8
        = s[8], s9 = s[9], s10 = s[10], s11 = s[11];
    float x0 = x[0], x1 = x[1], x2 = x[2];
    float n0 = n[0], n1 = n[1], n2 = n[2];
    float t0 = max(max(max(max(max(max(abs(s0), abs(s1)), abs(s2)), abs(s3)), abs(s4)), abs(s5)),
        abs(s6));
    float t1 = intBitsToFloat((int(min(1.0 - float(((floatBitsToInt(max(t0, abs(s7))) >> 23) & 255)
        - 127), 127.0)) + 127) << 23);
    float t2 = s0 * t1;
    float t3 = s4 * t1;
    float t4 = t2 + t3;
    float t5 = s3 * t1;
    float t6 = s7 * t1;
    float t7 = t5 + t6;
    float t8 = s2 * t1;
    float t9 = s6 * t1;
    float t10 = t8 + t9;
    float t11 = s1 * t1;
    float t12 = s5 * t1;
    float t13 = t11 + t12;
    float t14 = sqrt(t4 * t4 + t7 * t7 + t10 * t10 + t13 * t13);
    float t15 = 1.0 / max(t14, 1.4210855e-14);
    float t16 = t4 * t15;
    float t17 = t2 - t3;
    float t18 = t5 - t6;
    float t19 = t9 - t8;
    float t20 = t11 - t12;
    float t21 = sqrt(t17 * t17 + t18 * t18 + t19 * t19 + t20 * t20);
    float t22 = 1.0 / max(1.4210855e-14, t21);
    float t23 = t17 * t22;
    float t24 = t16 + t23;
    float t25 = t7 * t15;
    float t26 = t18 * t22;
    float t27 = t25 + t26;
    float t28 = t19 * t22;
    float t29 = t10 * t15;
    float t30 = t28 - t29;
    float t31 = t13 * t15;
    float t32 = t20 * t22;
    float t33 = t31 + t32;
    float t34 = sqrt(t24 * t24 + t27 * t27 + t30 * t30 + t33 * t33);
    float t35 = 1.0 / max(1.4210855e-14, t34);
    float t36 = t24 * t35;
    float t37 = t14 + t21;
    float t38 = 2.3841858e-07 * max(t14, t21);
    float t39 = 1.0 / sqrt(max(t14, t38) * max(t21, t38));
    float t40 = t37 * (0.5 * t39);
    float t41 = t36 * t40;
    float t42 = t39 * (2.0 * (t2 * t3 + t5 * t6 + t8 * t9 + t11 * t12) / t37);
    float t43 = t36 * t42;
    float t44 = t27 * t35;
    float t45 = t40 * t44;
    float t46 = t42 * t44;
    float t47 = t30 * t35;
    float t48 = t40 * t47;
    float t49 = t42 * t47;
    float t50 = t33 * t35;
    float t51 = t40 * t50;
    float t52 = t42 * t50;
    bool t53 = (t41 * t43 + t45 * t46 + t48 * t49 + t51 * t52 < 0.0);
    float t54 = t41 - t43;
    float t55 = t45 - t46;
    float t56 = t48 - t49;
    float t57 = t51 - t52;
    float t58 = 1.0 / (t54 * t54 + t55 * t55 + t56 * t56 + t57 * t57);
    float t59 = (t53 ? t54 * t58 : t41 + t43);
    float t60 = (t53 ? t55 * t58 : t45 + t46);
    float t61 = (t53 ? -(t56 * t58) : -(t48 + t49));
    float t62 = t59 * x0 + t60 * x1 - t61 * x2;
    float t63 = (t53 ? t57 * t58 : t51 + t52);
    float t64 = t59 * x1 + x2 * t63 - x0 * t60;
    float t65 = t59 * x2 + x0 * t61 - x1 * t63;
    float t66 = t60 * x2 + x0 * t63 + x1 * t61;
    float t67 = t16 * t36 + t25 * t44 - t29 * t47 + t31 * t50;
    float t68 = t1 * s8;
    float t69 = t16 * t44 - t25 * t36 + t29 * t50 + t31 * t47;
    float t70 = t1 * s9;
    float t71 = t29 * t36 - t31 * t44 + t16 * t47 + t25 * t50;
    float t72 = t1 * s10;
    float t73 = t16 * t50 - (t31 * t36 + t25 * t47) - t29 * t44;
    float t74 = t1 * s11;
    float t75 = t39 * (t67 * t68 + t69 * t70 + t71 * t72 - t73 * t74);
    float t76 = t39 * (t67 * t74 + t69 * t72 + t68 * t73 - t70 * t71);
    float t77 = t39 * (t67 * t72 - t69 * t74 - t68 * t71 - t70 * t73);
    float t78 = t39 * (t67 * t70 + t71 * t74 + t72 * t73 - t68 * t69);
    float t79 = 2.0 * (t36 * t76 - (t50 * t75 + t44 * t77) + t47 * t78) / max(t34, 1.1920929e-07);
    float t80 = t75 + t32 * t79;
    float t81 = t78 - t28 * t79;
    float t82 = t77 + t26 * t79;
    float t83 = t76 - t23 * t79;
    float t84 = t59 * t62 + t60 * t64 - t61 * t65 + t63 * t66 + -2.0 * (t59 * t80 + t60 * t81 - t61
        * t82 + t63 * t83);
    float t85 = t59 * t64 - t60 * t62 + t61 * t66 + t63 * t65 + -2.0 * (t59 * t81 - t60 * t80 + t61
        * t83 + t63 * t82);
    float t86 = t61 * t62 - t63 * t64 + t59 * t65 + t60 * t66 + -2.0 * (t61 * t80 - t63 * t81 + t59
        * t82 + t60 * t83);
    float t87 = t59 * n0 + t60 * n1 - t61 * n2;
    float t88 = t59 * n1 + t63 * n2 - t60 * n0;
    float t89 = t59 * n2 + t61 * n0 - t63 * n1;
    float t90 = t60 * n2 + t63 * n0 + t61 * n1;
    float t91 = 1.0 / (t59 * t59 + t60 * t60 + t61 * t61 + t63 * t63);
    out_out[0] = t84;
    out_out[1] = t85;
    out_out[2] = t86;
    out_out[3] = (t59 * t87 + t60 * t88 - t61 * t89 + t63 * t90) * t91;
    out_out[4] = t91 * (t59 * t88 - t60 * t87 + t61 * t90 + t63 * t89);
    out_out[5] = t91 * (t61 * t87 - t63 * t88 + t59 * t89 + t60 * t90);
}

/*
 * carry_matrix: A point and a normal carried by a sum of 3x4 matrices
 * m: m00, m01, m02, m03, m10, m11, m12, m13, m20, m21, m22, m23
 * x: x, y, z
 * n: x, y, z
 * out: x, y, z, nx, ny, nz
 */
void carry_matrix(float m[12], float x[3], float n[3], out float out_out[6])
{
    float m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3], m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7], m8
        = m[8], m9 = m[9], m10 = m[10], m11 = m[11];
    float x0 = x[0], x1 = x[1], x2 = x[2];
    float n0 = n[0], n1 = n[1], n2 = n[2];
    float t0 = m0 * n0 + m1 * n1 + m2 * n2;
    float t1 = m4 * n0 + m5 * n1 + m6 * n2;
    float t2 = m8 * n0 + m9 * n1 + m10 * n2;
    float t3 = 1.0 / sqrt(t0 * t0 + t1 * t1 + t2 * t2);
    out_out[0] = m0 * x0 + m1 * x1 + m2 * x2 + m3;
    out_out[1] = x0 * m4 + x1 * m5 + x2 * m6 + m7;
    out_out[2] = x0 * m8 + x1 * m9 + x2 * m10 + m11;
    out_out[3] = t0 * t3;
    out_out[4] = t1 * t3;
    out_out[5] = t2 * t3;
}
