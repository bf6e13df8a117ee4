/*
 * The filter's motion.
 * Written by `python -m motorcade.fusion.filter.model`; edit fusion/filter/model.
 */

#include "model.h"

#include <math.h>

void motorcade_step(const double pose[8], const double velocity[3], const double bias[6],
        const double rate[3], const double force[3], double dt, const double gravity[3],
        double next_pose[8], double next_velocity[3])
{
    const double pose0 = pose[0], pose1 = pose[1], pose2 = pose[2], pose3 = pose[3];
    const double pose4 = pose[4], pose5 = pose[5], pose6 = pose[6], pose7 = pose[7];
    const double velocity0 = velocity[0], velocity1 = velocity[1], velocity2 = velocity[2];
    const double bias0 = bias[0], bias1 = bias[1], bias2 = bias[2], bias3 = bias[3];
    const double bias4 = bias[4], bias5 = bias[5];
    const double rate0 = rate[0], rate1 = rate[1], rate2 = rate[2];
    const double force0 = force[0], force1 = force[1], force2 = force[2];
    const double gravity0 = gravity[0], gravity1 = gravity[1], gravity2 = gravity[2];
    const double t0 = (rate0 - bias0) * dt;
    const double t1 = dt * (rate1 - bias1);
    const double t2 = dt * (rate2 - bias2);
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const double t4 = t3 * (t3 * (7.052709893347381e-19 * t3 + -6.997110409172523e-16) +
        5.09682708028848e-13);
    const double t5 = t3 * (t3 * (t4 + -2.691144255102832e-10) + 9.688120033376813e-08) +
        -2.1701388888777376e-05;
    const double t6 = t3 * (t3 * (t3 * t5 + 0.002604166666666568) + -0.12499999999999997) + 1.0;
    const double t7 = t3 * (t3 * 4.1633367917298826e-20 + -4.6653082245299195e-17) +
        3.9206452611737776e-14;
    const double t8 = t3 * (t3 * (t3 * t7 + -2.4464948538103786e-11) + 1.0764577818542514e-08) +
        -3.1001984126925288e-06;
    const double t9 = 1.0 + t3 * (t3 * (t3 * t8 + 0.0005208333333333281) + -0.041666666666666664);
    const double t10 = -0.5 * t9;
    const double t11 = t2 * t10;
    const double t12 = t1 * t10;
    const double t13 = t0 * t10;
    const double t14 = pose0 * t6 - pose3 * t11 - pose2 * t12 - pose1 * t13;
    const double t15 = pose0 * t11 + t6 * pose3 - t12 * pose1 + pose2 * t13;
    const double t16 = pose3 * t13 - pose0 * t12 - t6 * pose2 - t11 * pose1;
    const double t17 = pose0 * t13 - t11 * pose2 + t6 * pose1 + pose3 * t12;
    const double t18 = 1.5 - 0.5 * (t14 * t14 + t15 * t15 + t16 * t16 + t17 * t17);
    const double t19 = dt * dt;
    const double t20 = force0 - bias3;
    const double t21 = t3 * (t3 * -1.7887548666180446e-20 + 8.188513482906969e-18) +
        -2.8111158093669925e-15;
    const double t22 = t3 * (t3 * (t3 * t21 + 7.647141733573578e-13) + -1.6059042958334888e-10) +
        2.5052108364066013e-08;
    const double t23 = t3 * (t3 * (t3 * t22 + -2.755731922368698e-06) + 0.0001984126984126772) +
        -0.008333333333333328;
    const double t24 = t3 * t23 + 0.16666666666666666;
    const double t25 = force2 - bias5;
    const double t26 = force1 - bias4;
    const double t27 = 0.5 * ((t1 * t25 - t2 * t26) * 2.0);
    const double t28 = t3 * (t3 * (t3 * 3.7613256748458153e-19 + -1.5560509287518826e-16) +
        4.778941032385404e-14);
    const double t29 = t3 * (t3 * (t28 + -1.1470716954992741e-11) + 2.0876756087900962e-09) +
        -2.7557319208087207e-07;
    const double t30 = t3 * (t3 * (t3 * t29 + 2.480158730144652e-05) + -0.0013888888888888408) +
        0.041666666666666664;
    const double t31 = 0.5 * (2.0 * (t0 * t26 - t1 * t20));
    const double t32 = 0.5 * (2.0 * (t2 * t20 - t0 * t25));
    const double t33 = 0.5 * (2.0 * (t1 * t31 - t2 * t32));
    const double t34 = -0.5 * (t19 * (0.5 * t20 + t24 * t27 + t30 * t33));
    const double t35 = 0.5 * (2.0 * (t2 * t27 - t0 * t31));
    const double t36 = -0.5 * (t19 * (0.5 * t26 + t24 * t32 + t30 * t35));
    const double t37 = 0.5 * (2.0 * (t0 * t32 - t1 * t27));
    const double t38 = -0.5 * (t19 * (0.5 * t25 + t24 * t31 + t30 * t37));
    const double t39 = t6 * t34 - t11 * t36 + t12 * t38;
    const double t40 = t11 * t34 + t6 * t36 - t13 * t38;
    const double t41 = t13 * t36 - t12 * t34 + t6 * t38;
    const double t42 = -0.5 * (dt * velocity0 + dt * (dt * (0.5 * gravity0)));
    const double t43 = -0.5 * (dt * velocity1 + dt * (dt * (0.5 * gravity1)));
    const double t44 = -0.5 * (dt * velocity2 + dt * (dt * (0.5 * gravity2)));
    const double t45 = pose4 + pose0 * t42 - pose3 * t43 + pose2 * t44;
    const double t46 = t13 * t34 + t11 * t38 + t12 * t36;
    const double t47 = pose5 + pose3 * t42 + pose0 * t43 - pose1 * t44;
    const double t48 = pose6 - pose2 * t42 + pose1 * t43 + pose0 * t44;
    const double t49 = pose0 * t39 + pose3 * t40 - pose2 * t41 + t6 * t45 - pose1 * t46 - t11 * t47
        + t12 * t48;
    const double t50 = pose7 + pose1 * t42 + pose3 * t44 + pose2 * t43;
    const double t51 = t49 - t13 * t50;
    const double t52 = pose0 * t46 + pose3 * t41 + t13 * t45 + pose1 * t39 + t11 * t48 + t6 * t50 +
        pose2 * t40;
    const double t53 = t52 + t12 * t47;
    const double t54 = pose0 * t41 - t12 * t45 + t13 * t47 + t6 * t48 - pose3 * t46 + pose2 * t39 -
        pose1 * t40;
    const double t55 = t54 - t11 * t50;
    const double t56 = pose0 * t40 - pose2 * t46 + t11 * t45 + pose1 * t41 + t6 * t47 - t12 * t50 -
        pose3 * t39;
    const double t57 = t56 - t13 * t48;
    const double t58 = 0.5 * (2.0 * (t14 * t53 + t16 * t57 - t15 * t55 - t17 * t51));
    const double t59 = t9 * (t9 * 0.5);
    const double t60 = dt * (t20 + t27 * t59 + t24 * t33);
    const double t61 = dt * (t26 + t32 * t59 + t24 * t35);
    const double t62 = dt * (t25 + t31 * t59 + t24 * t37);
    const double t63 = pose0 * t60 + pose3 * t61 - pose2 * t62;
    const double t64 = pose0 * t61 + pose1 * t62 - pose3 * t60;
    const double t65 = pose0 * t62 + pose2 * t60 - pose1 * t61;
    const double t66 = pose3 * t62 + pose1 * t60 + pose2 * t61;
    next_pose[0] = t14 * t18;
    next_pose[1] = t17 * t18;
    next_pose[2] = -(t16 * t18);
    next_pose[3] = t15 * t18;
    next_pose[4] = t18 * t51 + t17 * t58;
    next_pose[5] = t18 * t57 - t16 * t58;
    next_pose[6] = t18 * t55 + t15 * t58;
    next_pose[7] = t18 * t53 - t14 * t58;
    next_velocity[0] = velocity0 + dt * gravity0 + (pose0 * t63 + pose3 * t64 - pose2 * t65 + pose1
        * t66);
    next_velocity[1] = velocity1 + dt * gravity1 + (pose0 * t64 - pose3 * t63 + pose2 * t66 + pose1
        * t65);
    next_velocity[2] = velocity2 + dt * gravity2 + (pose2 * t63 - pose1 * t64 + pose0 * t65 + pose3
        * t66);
}

void motorcade_transition(const double bias[6], const double rate[3], const double force[3],
        double dt, double turn_turn[9], double position_turn[9], double velocity_turn[9],
        double turn_gyro[9], double position_gyro[9], double velocity_gyro[9],
        double position_accel[9], double velocity_accel[9])
{
    const double bias0 = bias[0], bias1 = bias[1], bias2 = bias[2], bias3 = bias[3];
    const double bias4 = bias[4], bias5 = bias[5];
    const double rate0 = rate[0], rate1 = rate[1], rate2 = rate[2];
    const double force0 = force[0], force1 = force[1], force2 = force[2];
    const double t0 = (rate0 - bias0) * dt;
    const double t1 = t0 * t0;
    const double t2 = dt * (rate1 - bias1);
    const double t3 = t2 * t2;
    const double t4 = t1 + t3;
    const double t5 = dt * (rate2 - bias2);
    const double t6 = t5 * t5;
    const double t7 = t4 + t6;
    const double t8 = 7.052709893347381e-19 * t7;
    const double t9 = t8 + -6.997110409172523e-16;
    const double t10 = t7 * t9 + 5.09682708028848e-13;
    const double t11 = t7 * t10 + -2.691144255102832e-10;
    const double t12 = t7 * t11 + 9.688120033376813e-08;
    const double t13 = t7 * t12 + -2.1701388888777376e-05;
    const double t14 = t7 * t13 + 0.002604166666666568;
    const double t15 = t7 * t14 + -0.12499999999999997;
    const double t16 = t7 * t15 + 1.0;
    const double t17 = t16 * -0.5;
    const double t18 = t16 * t17;
    const double t19 = t7 * 4.1633367917298826e-20;
    const double t20 = t19 + -4.6653082245299195e-17;
    const double t21 = t7 * t20 + 3.9206452611737776e-14;
    const double t22 = t7 * t21 + -2.4464948538103786e-11;
    const double t23 = t7 * t22 + 1.0764577818542514e-08;
    const double t24 = t7 * t23 + -3.1001984126925288e-06;
    const double t25 = t7 * t24 + 0.0005208333333333281;
    const double t26 = t7 * t25 + -0.041666666666666664;
    const double t27 = 1.0 + t7 * t26;
    const double t28 = -0.5 * t27;
    const double t29 = t2 * t28;
    const double t30 = -0.5 * t29;
    const double t31 = t29 * t30;
    const double t32 = t0 * t28;
    const double t33 = -0.5 * t32;
    const double t34 = t32 * t33;
    const double t35 = t5 * t28;
    const double t36 = -0.5 * t35;
    const double t37 = t35 * t36;
    const double t38 = t29 * t33;
    const double t39 = t16 * t36;
    const double t40 = t30 * t32;
    const double t41 = t17 * t35;
    const double t42 = t16 * t30;
    const double t43 = t17 * t29;
    const double t44 = t32 * t36;
    const double t45 = t33 * t35;
    const double t46 = t16 * t33;
    const double t47 = t30 * t35;
    const double t48 = t29 * t36;
    const double t49 = t17 * t32;
    const double t50 = dt * dt;
    const double t51 = force0 - bias3;
    const double t52 = t7 * -1.7887548666180446e-20;
    const double t53 = t52 + 8.188513482906969e-18;
    const double t54 = t7 * t53 + -2.8111158093669925e-15;
    const double t55 = t7 * t54 + 7.647141733573578e-13;
    const double t56 = t7 * t55 + -1.6059042958334888e-10;
    const double t57 = t7 * t56 + 2.5052108364066013e-08;
    const double t58 = t7 * t57 + -2.755731922368698e-06;
    const double t59 = t7 * t58 + 0.0001984126984126772;
    const double t60 = t7 * t59 + -0.008333333333333328;
    const double t61 = t7 * t60 + 0.16666666666666666;
    const double t62 = force2 - bias5;
    const double t63 = force1 - bias4;
    const double t64 = 0.5 * ((t2 * t62 - t5 * t63) * 2.0);
    const double t65 = t7 * 3.7613256748458153e-19;
    const double t66 = t65 + -1.5560509287518826e-16;
    const double t67 = t7 * t66 + 4.778941032385404e-14;
    const double t68 = t7 * t67 + -1.1470716954992741e-11;
    const double t69 = t7 * t68 + 2.0876756087900962e-09;
    const double t70 = t7 * t69 + -2.7557319208087207e-07;
    const double t71 = t7 * t70 + 2.480158730144652e-05;
    const double t72 = t7 * t71 + -0.0013888888888888408;
    const double t73 = t7 * t72 + 0.041666666666666664;
    const double t74 = 0.5 * (2.0 * (t0 * t63 - t2 * t51));
    const double t75 = 0.5 * (2.0 * (t5 * t51 - t0 * t62));
    const double t76 = 0.5 * (2.0 * (t2 * t74 - t5 * t75));
    const double t77 = -0.5 * (t50 * (0.5 * t51 + t61 * t64 + t73 * t76));
    const double t78 = 0.5 * (2.0 * (t5 * t64 - t0 * t74));
    const double t79 = -0.5 * (t50 * (0.5 * t63 + t61 * t75 + t73 * t78));
    const double t80 = 0.5 * (2.0 * (t0 * t75 - t2 * t64));
    const double t81 = -0.5 * (t50 * (0.5 * t62 + t61 * t74 + t73 * t80));
    const double t82 = t16 * t77 - t35 * t79 + t29 * t81;
    const double t83 = t33 * t82;
    const double t84 = t32 * t77 + t35 * t81 + t29 * t79;
    const double t85 = -0.5 * t84;
    const double t86 = t16 * t85;
    const double t87 = t32 * t79 - t29 * t77 + t16 * t81;
    const double t88 = -0.5 * t87;
    const double t89 = t35 * t88;
    const double t90 = t35 * t77 + t16 * t79 - t32 * t81;
    const double t91 = -0.5 * t90;
    const double t92 = t29 * t91;
    const double t93 = -0.5 * t82;
    const double t94 = t32 * t93;
    const double t95 = t30 * t90;
    const double t96 = t36 * t87;
    const double t97 = t17 * t84;
    const double t98 = t35 * t85;
    const double t99 = t16 * t88;
    const double t100 = t29 * t93;
    const double t101 = t30 * t82;
    const double t102 = t32 * t91;
    const double t103 = t33 * t90;
    const double t104 = t17 * t87;
    const double t105 = t36 * t84;
    const double t106 = t16 * t91;
    const double t107 = t35 * t93;
    const double t108 = t29 * t85;
    const double t109 = t36 * t82;
    const double t110 = t32 * t88;
    const double t111 = t17 * t90;
    const double t112 = t33 * t87;
    const double t113 = t30 * t84;
    const double t114 = t29 * t88;
    const double t115 = t16 * t93;
    const double t116 = t17 * t82;
    const double t117 = t32 * t85;
    const double t118 = t36 * t90;
    const double t119 = t33 * t84;
    const double t120 = t35 * t91;
    const double t121 = t30 * t87;
    const double t122 = t27 * 0.5;
    const double t123 = t27 * t122;
    const double t124 = dt * (t62 + t74 * t123 + t61 * t80);
    const double t125 = t35 * t124;
    const double t126 = dt * (t63 + t75 * t123 + t61 * t78);
    const double t127 = t29 * t126;
    const double t128 = t125 + t127;
    const double t129 = t16 * t124;
    const double t130 = t32 * t126;
    const double t131 = t129 + t130;
    const double t132 = t16 * t126;
    const double t133 = t32 * t124;
    const double t134 = t132 - t133;
    const double t135 = t35 * t126;
    const double t136 = t29 * t124;
    const double t137 = t135 - t136;
    const double t138 = dt * (t51 + t64 * t123 + t61 * t76);
    const double t139 = t29 * t138;
    const double t140 = t129 - t139;
    const double t141 = t32 * t138;
    const double t142 = t125 + t141;
    const double t143 = t16 * t138;
    const double t144 = t136 + t143;
    const double t145 = t35 * t138;
    const double t146 = t133 - t145;
    const double t147 = t127 + t141;
    const double t148 = t132 + t145;
    const double t149 = t143 - t135;
    const double t150 = t139 - t130;
    const double t151 = dt * (t0 * 2.0);
    const double t152 = t7 * (t7 * (t7 * (t7 * (t8 * t151 + t9 * t151) + t10 * t151) + t11 * t151) +
        t12 * t151);
    const double t153 = t7 * (t7 * (t152 + t13 * t151) + t14 * t151) + t15 * t151;
    const double t154 = t7 * (t7 * (t7 * (t7 * (t19 * t151 + t20 * t151) + t21 * t151) + t22 * t151)
        + t23 * t151);
    const double t155 = t7 * (t7 * (t154 + t24 * t151) + t25 * t151) + t26 * t151;
    const double t156 = -0.5 * t155;
    const double t157 = dt * t28;
    const double t158 = t0 * t156 + t157;
    const double t159 = t5 * t156;
    const double t160 = t2 * t156;
    const double t161 = dt * (t2 * 2.0);
    const double t162 = t7 * (t7 * (t7 * (t7 * (t8 * t161 + t9 * t161) + t10 * t161) + t11 * t161) +
        t12 * t161);
    const double t163 = t7 * (t7 * (t162 + t13 * t161) + t14 * t161) + t15 * t161;
    const double t164 = t7 * (t7 * (t7 * (t7 * (t19 * t161 + t20 * t161) + t21 * t161) + t22 * t161)
        + t23 * t161);
    const double t165 = t7 * (t7 * (t164 + t24 * t161) + t25 * t161) + t26 * t161;
    const double t166 = -0.5 * t165;
    const double t167 = t0 * t166;
    const double t168 = t5 * t166;
    const double t169 = t157 + t2 * t166;
    const double t170 = dt * (t5 * 2.0);
    const double t171 = t7 * (t7 * (t7 * (t7 * (t8 * t170 + t9 * t170) + t10 * t170) + t11 * t170) +
        t12 * t170);
    const double t172 = t7 * (t7 * (t171 + t13 * t170) + t14 * t170) + t15 * t170;
    const double t173 = t7 * (t7 * (t7 * (t7 * (t19 * t170 + t20 * t170) + t21 * t170) + t22 * t170)
        + t23 * t170);
    const double t174 = t7 * (t7 * (t173 + t24 * t170) + t25 * t170) + t26 * t170;
    const double t175 = -0.5 * t174;
    const double t176 = t0 * t175;
    const double t177 = t157 + t5 * t175;
    const double t178 = t2 * t175;
    const double t179 = dt * t62;
    const double t180 = dt * t75;
    const double t181 = t0 * t179 - t180;
    const double t182 = t7 * (t7 * (t7 * (t7 * (t65 * t151 + t66 * t151) + t67 * t151) + t68 * t151)
        + t69 * t151);
    const double t183 = t7 * (t7 * (t182 + t70 * t151) + t71 * t151) + t72 * t151;
    const double t184 = t7 * (t7 * (t7 * (t7 * (t52 * t151 + t53 * t151) + t54 * t151) + t55 * t151)
        + t56 * t151);
    const double t185 = t7 * (t7 * (t7 * (t184 + t57 * t151) + t58 * t151) + t59 * t151) + t60 *
        t151;
    const double t186 = dt * t63;
    const double t187 = t61 * t186;
    const double t188 = -0.5 * (t50 * (t73 * t181 - t80 * t183 - (t74 * t185 + t187)));
    const double t189 = t2 * t186;
    const double t190 = t5 * t179;
    const double t191 = t189 + t190;
    const double t192 = -0.5 * (t50 * (t64 * t185 + (t76 * t183 + t73 * t191)));
    const double t193 = t61 * t179;
    const double t194 = dt * t74;
    const double t195 = t0 * t186 + t194;
    const double t196 = -0.5 * (t50 * (t193 - t75 * t185 + (t73 * t195 - t78 * t183)));
    const double t197 = t29 * t188 - t81 * t160 - (t16 * t192 + t77 * t153 + (t35 * t196 - t79 *
        t159));
    const double t198 = t16 * t196 - t79 * t153 - (t35 * t192 + t77 * t159) - (t32 * t188 - t81 *
        t158);
    const double t199 = t32 * t196 - t79 * t158 + (t29 * t192 + t77 * t160) + (t16 * t188 - t81 *
        t153);
    const double t200 = t35 * t188 - t81 * t159 - (t32 * t192 + t77 * t158) + (t29 * t196 - t79 *
        t160);
    const double t201 = t16 * t197 - t35 * t198 + t29 * t199 + t82 * t153 + t32 * t200 - t90 * t159
        + t87 * t160;
    const double t202 = dt * t51;
    const double t203 = t2 * t202 - t194;
    const double t204 = t7 * (t7 * (t7 * (t7 * (t65 * t161 + t66 * t161) + t67 * t161) + t68 * t161)
        + t69 * t161);
    const double t205 = t7 * (t7 * (t204 + t70 * t161) + t71 * t161) + t72 * t161;
    const double t206 = t7 * (t7 * (t7 * (t7 * (t52 * t161 + t53 * t161) + t54 * t161) + t55 * t161)
        + t56 * t161);
    const double t207 = t7 * (t7 * (t7 * (t206 + t57 * t161) + t58 * t161) + t59 * t161) + t60 *
        t161;
    const double t208 = -0.5 * (t50 * (t73 * t203 - t76 * t205 - (t193 + t64 * t207)));
    const double t209 = t0 * t202;
    const double t210 = t190 + t209;
    const double t211 = -0.5 * (t50 * (t75 * t207 + (t78 * t205 + t73 * t210)));
    const double t212 = t61 * t202;
    const double t213 = dt * t64;
    const double t214 = t2 * t179 + t213;
    const double t215 = -0.5 * (t50 * (t212 - t74 * t207 + (t73 * t214 - t80 * t205)));
    const double t216 = t16 * t208 - t77 * t163 + (t35 * t211 + t79 * t168) + (t29 * t215 - t81 *
        t169);
    const double t217 = t35 * t208 - t77 * t168 - (t16 * t211 + t79 * t163) - (t32 * t215 - t81 *
        t167);
    const double t218 = t16 * t215 - t81 * t163 - (t32 * t211 + t79 * t167 + (t29 * t208 - t77 *
        t169));
    const double t219 = t32 * t208 - t77 * t167 + (t35 * t215 - t81 * t168) - (t29 * t211 + t79 *
        t169);
    const double t220 = t16 * t216 - t35 * t217 + t29 * t218 + t82 * t163 + t32 * t219 - t90 * t168
        + t87 * t169;
    const double t221 = t7 * (t7 * (t7 * (t7 * (t52 * t170 + t53 * t170) + t54 * t170) + t55 * t170)
        + t56 * t170);
    const double t222 = t7 * (t7 * (t7 * (t221 + t57 * t170) + t58 * t170) + t59 * t170) + t60 *
        t170;
    const double t223 = t180 + t5 * t202;
    const double t224 = t7 * (t7 * (t7 * (t7 * (t65 * t170 + t66 * t170) + t67 * t170) + t68 * t170)
        + t69 * t170);
    const double t225 = t7 * (t7 * (t224 + t70 * t170) + t71 * t170) + t72 * t170;
    const double t226 = -0.5 * (t50 * (t187 - t64 * t222 + (t73 * t223 - t76 * t225)));
    const double t227 = t5 * t186 - t213;
    const double t228 = -0.5 * (t50 * (t73 * t227 - t78 * t225 - (t212 + t75 * t222)));
    const double t229 = t189 + t209;
    const double t230 = -0.5 * (t50 * (t74 * t222 + (t80 * t225 + t73 * t229)));
    const double t231 = t16 * t226 - t77 * t172 - (t35 * t228 - t79 * t177) - (t29 * t230 + t81 *
        t178);
    const double t232 = t35 * t226 - t77 * t177 + (t16 * t228 - t79 * t172) + (t32 * t230 + t81 *
        t176);
    const double t233 = t32 * t228 - t79 * t176 - (t29 * t226 - t77 * t178) - (t16 * t230 + t81 *
        t172);
    const double t234 = t32 * t226 - t77 * t176 - (t35 * t230 + t81 * t177) + (t29 * t228 - t79 *
        t178);
    const double t235 = t16 * t231 - t35 * t232 + t29 * t233 + t82 * t172 + t32 * t234 - t90 * t177
        + t87 * t178;
    const double t236 = t16 * t198 + t29 * t200 + t82 * t159 - t32 * t199 + t90 * t153 + t84 * t160
        + t35 * t197;
    const double t237 = t16 * t217 + t29 * t219 + t82 * t168 - t32 * t218 + t90 * t163 + t84 * t169
        + t35 * t216;
    const double t238 = t16 * t232 + t29 * t234 + t82 * t177 - t32 * t233 + t90 * t172 + t84 * t178
        + t35 * t231;
    const double t239 = t16 * t199 - t82 * t160 + t90 * t158 + t87 * t153 + t35 * t200 - t29 * t197
        + t32 * t198;
    const double t240 = t16 * t218 - t82 * t169 + t90 * t167 + t87 * t163 + t35 * t219 - t29 * t216
        + t32 * t217;
    const double t241 = t16 * t233 - t82 * t178 + t90 * t176 + t87 * t172 + t35 * t234 - t29 * t231
        + t32 * t232;
    const double t242 = t122 * t155;
    const double t243 = t242 + t242;
    const double t244 = t123 * t186;
    const double t245 = dt * (t61 * t181 - t80 * t185 - (t74 * t243 + t244));
    const double t246 = dt * (t64 * t243 + (t76 * t185 + t61 * t191));
    const double t247 = t123 * t179;
    const double t248 = dt * (t247 - t75 * t243 + (t61 * t195 - t78 * t185));
    const double t249 = t29 * t245 - (t16 * t246 + t35 * t248);
    const double t250 = t16 * t248 - t32 * t245 - t35 * t246;
    const double t251 = t16 * t245 + t29 * t246 + t32 * t248;
    const double t252 = t35 * t245 - t32 * t246 + t29 * t248;
    const double t253 = t122 * t165;
    const double t254 = t253 + t253;
    const double t255 = dt * (t61 * t203 - t76 * t207 - (t247 + t64 * t254));
    const double t256 = dt * (t75 * t254 + (t78 * t207 + t61 * t210));
    const double t257 = t123 * t202;
    const double t258 = dt * (t257 - t74 * t254 + (t61 * t214 - t80 * t207));
    const double t259 = t16 * t255 + t35 * t256 + t29 * t258;
    const double t260 = t35 * t255 - (t16 * t256 + t32 * t258);
    const double t261 = t16 * t258 - t29 * t255 - t32 * t256;
    const double t262 = t35 * t258 + t32 * t255 - t29 * t256;
    const double t263 = t122 * t174;
    const double t264 = t263 + t263;
    const double t265 = dt * (t244 - t64 * t264 + (t61 * t223 - t76 * t222));
    const double t266 = dt * (t61 * t227 - t78 * t222 - (t257 + t75 * t264));
    const double t267 = dt * (t74 * t264 + (t80 * t222 + t61 * t229));
    const double t268 = t16 * t265 - t35 * t266 - t29 * t267;
    const double t269 = t16 * t266 + t32 * t267 + t35 * t265;
    const double t270 = t32 * t266 - (t16 * t267 + t29 * t265);
    const double t271 = t32 * t265 - t35 * t267 + t29 * t266;
    const double t272 = t3 + t6;
    const double t273 = -0.5 * (t50 * (-0.5 + t73 * t272));
    const double t274 = t5 * t61;
    const double t275 = t0 * t2;
    const double t276 = t73 * t275;
    const double t277 = -0.5 * (t50 * (t274 + t276));
    const double t278 = t2 * t61;
    const double t279 = t0 * t5;
    const double t280 = t73 * t279;
    const double t281 = -0.5 * (t50 * (t278 - t280));
    const double t282 = t16 * t273 + t35 * t277 + t29 * t281;
    const double t283 = t35 * t273 - t16 * t277 - t32 * t281;
    const double t284 = t16 * t281 - (t32 * t277 + t29 * t273);
    const double t285 = t32 * t273 + t35 * t281 - t29 * t277;
    const double t286 = -0.5 * (t50 * (t274 - t276));
    const double t287 = t1 + t6;
    const double t288 = -0.5 * (t50 * (-0.5 + t73 * t287));
    const double t289 = t0 * t61;
    const double t290 = t2 * t5;
    const double t291 = t73 * t290;
    const double t292 = -0.5 * (t50 * (t289 + t291));
    const double t293 = t16 * t286 - t35 * t288 - t29 * t292;
    const double t294 = t35 * t286 + t16 * t288 + t32 * t292;
    const double t295 = t32 * t288 - t29 * t286 - t16 * t292;
    const double t296 = t32 * t286 - t35 * t292 + t29 * t288;
    const double t297 = -0.5 * (t50 * (-0.5 + t4 * t73));
    const double t298 = -0.5 * (t50 * (t278 + t280));
    const double t299 = -0.5 * (t50 * (t289 - t291));
    const double t300 = t29 * t297 - (t16 * t298 + t35 * t299);
    const double t301 = t16 * t299 - t35 * t298 - t32 * t297;
    const double t302 = t32 * t299 + t29 * t298 + t16 * t297;
    const double t303 = t35 * t297 - t32 * t298 + t29 * t299;
    const double t304 = dt * (-1.0 + t61 * t272);
    const double t305 = t5 * t123;
    const double t306 = t61 * t275;
    const double t307 = dt * (t305 + t306);
    const double t308 = t2 * t123;
    const double t309 = t61 * t279;
    const double t310 = dt * (t308 - t309);
    const double t311 = t16 * t304 + t35 * t307 + t29 * t310;
    const double t312 = t35 * t304 - (t16 * t307 + t32 * t310);
    const double t313 = t16 * t310 - t29 * t304 - t32 * t307;
    const double t314 = t35 * t310 + t32 * t304 - t29 * t307;
    const double t315 = dt * (t305 - t306);
    const double t316 = dt * (-1.0 + t61 * t287);
    const double t317 = t0 * t123;
    const double t318 = t61 * t290;
    const double t319 = dt * (t317 + t318);
    const double t320 = t16 * t315 - t35 * t316 - t29 * t319;
    const double t321 = t16 * t316 + t32 * t319 + t35 * t315;
    const double t322 = t32 * t316 - (t16 * t319 + t29 * t315);
    const double t323 = t32 * t315 - t35 * t319 + t29 * t316;
    const double t324 = dt * (-1.0 + t4 * t61);
    const double t325 = dt * (t308 + t309);
    const double t326 = dt * (t317 - t318);
    const double t327 = t29 * t324 - (t16 * t325 + t35 * t326);
    const double t328 = t16 * t326 - t32 * t324 - t35 * t325;
    const double t329 = t16 * t324 + t29 * t325 + t32 * t326;
    const double t330 = t35 * t324 - t32 * t325 + t29 * t326;
    turn_turn[0] = -2.0 * (t18 - t31 + t34 - t37);
    turn_turn[1] = -2.0 * (t38 - t39 + t40 - t41);
    turn_turn[2] = -2.0 * (t42 + t43 + t44 + t45);
    turn_turn[3] = -2.0 * (t40 + (t38 + (t39 + t41)));
    turn_turn[4] = -(-2.0 * (t34 + (t37 - t18 - t31)));
    turn_turn[5] = -(-2.0 * (t46 - t47 - t48 + t49));
    turn_turn[6] = -2.0 * (t44 + (t45 - t42) - t43);
    turn_turn[7] = -2.0 * (t48 + (t49 + (t46 + t47)));
    turn_turn[8] = -2.0 * (t18 + t37 - t34 - t31);
    position_turn[0] = -2.0 * (t83 - (t86 + t89 + t92) + t94 - t95 - t96 - t97);
    position_turn[1] = -2.0 * (t98 - t99 + t100 + t101 + t102 + t103 - t104 + t105);
    position_turn[2] = -2.0 * (t106 + t107 - t108 + t109 + t110 + t111 + t112 - t113);
    position_turn[3] = -2.0 * (t104 + (t103 + (t102 + (t101 + (t99 + t100))) - t105 - t98));
    position_turn[4] = -2.0 * (t95 + (t92 - t86 - t83 - t94) - t97 - t89 - t96);
    position_turn[5] = -2.0 * (t114 - t115 - t116 + t117 + t118 + t119 + t120 + t121);
    position_turn[6] = -2.0 * (t113 + (t110 + (t108 + (t107 + (t112 + (t109 - t106 - t111))))));
    position_turn[7] = -2.0 * (t114 + (t120 + (t121 + (t118 + (t115 + t116)))) - t117 - t119);
    position_turn[8] = -2.0 * (t89 + (t96 - (t95 + (t83 + t86))) - t92 - t94 - t97);
    velocity_turn[0] = t16 * t128 + t35 * t131 + t29 * t134 + t32 * t137;
    velocity_turn[1] = t16 * t140 - t35 * t142 - t29 * t144 + t32 * t146;
    velocity_turn[2] = t29 * t147 - (t16 * t148 + t35 * t149) + t32 * t150;
    velocity_turn[3] = t35 * t128 - t16 * t131 + t29 * t137 - t32 * t134;
    velocity_turn[4] = t35 * t140 + t16 * t142 + t29 * t146 + t32 * t144;
    velocity_turn[5] = t16 * t149 - t35 * t148 + t29 * t150 - t32 * t147;
    velocity_turn[6] = t16 * t134 - (t32 * t131 + t29 * t128) + t35 * t137;
    velocity_turn[7] = t32 * t142 - t29 * t140 - t16 * t144 + t35 * t146;
    velocity_turn[8] = t32 * t149 + t29 * t148 + t16 * t147 + t35 * t150;
    turn_gyro[0] = -2.0 * (t32 * t153 - (t16 * t158 + t29 * t159) + t35 * t160);
    turn_gyro[1] = -2.0 * (t32 * t163 - (t16 * t167 + t29 * t168) + t35 * t169);
    turn_gyro[2] = -2.0 * (t32 * t172 - (t16 * t176 + t29 * t177) + t35 * t178);
    turn_gyro[3] = -(-2.0 * (t16 * t160 + t35 * t158 - t29 * t153 - t32 * t159));
    turn_gyro[4] = -(-2.0 * (t16 * t169 + t35 * t167 - t29 * t163 - t32 * t168));
    turn_gyro[5] = -(-2.0 * (t16 * t178 + t35 * t176 - t29 * t172 - t32 * t177));
    turn_gyro[6] = -2.0 * (t35 * t153 - t16 * t159 - t32 * t160 + t29 * t158);
    turn_gyro[7] = -2.0 * (t35 * t163 - t16 * t168 - t32 * t169 + t29 * t167);
    turn_gyro[8] = -2.0 * (t35 * t172 - t16 * t177 - t32 * t178 + t29 * t176);
    position_gyro[0] = -2.0 * (t201 + t84 * t158);
    position_gyro[1] = -2.0 * (t220 + t84 * t167);
    position_gyro[2] = -2.0 * (t235 + t84 * t176);
    position_gyro[3] = -2.0 * (t236 - t87 * t158);
    position_gyro[4] = -2.0 * (t237 - t87 * t167);
    position_gyro[5] = -2.0 * (t238 - t87 * t176);
    position_gyro[6] = -2.0 * (t239 + t84 * t159);
    position_gyro[7] = -2.0 * (t240 + t84 * t168);
    position_gyro[8] = -2.0 * (t241 + t84 * t177);
    velocity_gyro[0] = t16 * t249 - t35 * t250 + t29 * t251 + t32 * t252;
    velocity_gyro[1] = t16 * t259 - t35 * t260 + t29 * t261 + t32 * t262;
    velocity_gyro[2] = t16 * t268 - t35 * t269 + t29 * t270 + t32 * t271;
    velocity_gyro[3] = t35 * t249 + t16 * t250 + t29 * t252 - t32 * t251;
    velocity_gyro[4] = t35 * t259 + t16 * t260 + t29 * t262 - t32 * t261;
    velocity_gyro[5] = t35 * t268 + t16 * t269 + t29 * t271 - t32 * t270;
    velocity_gyro[6] = t32 * t250 - t29 * t249 + t16 * t251 + t35 * t252;
    velocity_gyro[7] = t32 * t260 - t29 * t259 + t16 * t261 + t35 * t262;
    velocity_gyro[8] = t32 * t269 - t29 * t268 + t16 * t270 + t35 * t271;
    position_accel[0] = -2.0 * (t16 * t282 - t35 * t283 + t29 * t284 + t32 * t285);
    position_accel[1] = -2.0 * (t16 * t293 - t35 * t294 + t29 * t295 + t32 * t296);
    position_accel[2] = -2.0 * (t16 * t300 - t35 * t301 + t29 * t302 + t32 * t303);
    position_accel[3] = -2.0 * (t16 * t283 + t29 * t285 - t32 * t284 + t35 * t282);
    position_accel[4] = -2.0 * (t16 * t294 + t29 * t296 - t32 * t295 + t35 * t293);
    position_accel[5] = -2.0 * (t16 * t301 + t29 * t303 - t32 * t302 + t35 * t300);
    position_accel[6] = -2.0 * (t16 * t284 + t35 * t285 - t29 * t282 + t32 * t283);
    position_accel[7] = -2.0 * (t16 * t295 + t35 * t296 - t29 * t293 + t32 * t294);
    position_accel[8] = -2.0 * (t16 * t302 + t35 * t303 - t29 * t300 + t32 * t301);
    velocity_accel[0] = t16 * t311 - t35 * t312 + t29 * t313 + t32 * t314;
    velocity_accel[1] = t16 * t320 - t35 * t321 + t29 * t322 + t32 * t323;
    velocity_accel[2] = t16 * t327 - t35 * t328 + t29 * t329 + t32 * t330;
    velocity_accel[3] = t35 * t311 + t16 * t312 + t29 * t314 - t32 * t313;
    velocity_accel[4] = t35 * t320 + t16 * t321 + t29 * t323 - t32 * t322;
    velocity_accel[5] = t35 * t327 + t16 * t328 + t29 * t330 - t32 * t329;
    velocity_accel[6] = t32 * t312 - t29 * t311 + t16 * t313 + t35 * t314;
    velocity_accel[7] = t32 * t321 - t29 * t320 + t16 * t322 + t35 * t323;
    velocity_accel[8] = t32 * t328 - t29 * t327 + t16 * t329 + t35 * t330;
}

void motorcade_held_step(const double pose[8], const double velocity[3], const double bias[6],
        const double rate[3], const double force[3], double dt, const double gravity[3],
        double next_pose[8], double next_velocity[3])
{
    const double pose0 = pose[0], pose1 = pose[1], pose2 = pose[2], pose3 = pose[3];
    const double pose4 = pose[4], pose5 = pose[5], pose6 = pose[6], pose7 = pose[7];
    const double velocity0 = velocity[0], velocity1 = velocity[1], velocity2 = velocity[2];
    const double bias0 = bias[0], bias1 = bias[1], bias2 = bias[2], bias3 = bias[3];
    const double bias4 = bias[4], bias5 = bias[5];
    const double rate0 = rate[0], rate1 = rate[1], rate2 = rate[2];
    const double force0 = force[0], force1 = force[1], force2 = force[2];
    const double gravity0 = gravity[0], gravity1 = gravity[1], gravity2 = gravity[2];
    const double t0 = (rate0 - bias0) * dt;
    const double t1 = dt * (rate1 - bias1);
    const double t2 = dt * (rate2 - bias2);
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const double t4 = t3 * (t3 * (7.052709893347381e-19 * t3 + -6.997110409172523e-16) +
        5.09682708028848e-13);
    const double t5 = t3 * (t3 * (t4 + -2.691144255102832e-10) + 9.688120033376813e-08) +
        -2.1701388888777376e-05;
    const double t6 = t3 * (t3 * (t3 * t5 + 0.002604166666666568) + -0.12499999999999997) + 1.0;
    const double t7 = t3 * (t3 * 4.1633367917298826e-20 + -4.6653082245299195e-17) +
        3.9206452611737776e-14;
    const double t8 = t3 * (t3 * (t3 * t7 + -2.4464948538103786e-11) + 1.0764577818542514e-08) +
        -3.1001984126925288e-06;
    const double t9 = -0.5 * (1.0 + t3 * (t3 * (t3 * t8 + 0.0005208333333333281) +
        -0.041666666666666664));
    const double t10 = t2 * t9;
    const double t11 = t1 * t9;
    const double t12 = t0 * t9;
    const double t13 = pose0 * t6 - pose3 * t10 - pose2 * t11 - pose1 * t12;
    const double t14 = pose0 * t10 + t6 * pose3 - t11 * pose1 + pose2 * t12;
    const double t15 = pose3 * t12 - pose0 * t11 - t6 * pose2 - t10 * pose1;
    const double t16 = pose0 * t12 - t10 * pose2 + t6 * pose1 + pose3 * t11;
    const double t17 = 1.5 - 0.5 * (t13 * t13 + t14 * t14 + t15 * t15 + t16 * t16);
    const double t18 = dt * 0.5;
    const double t19 = dt * (force0 - bias3);
    const double t20 = -0.5 * (t18 * t19);
    const double t21 = dt * (force1 - bias4);
    const double t22 = -0.5 * (t18 * t21);
    const double t23 = dt * (force2 - bias5);
    const double t24 = -0.5 * (t18 * t23);
    const double t25 = t6 * t20 - t10 * t22 + t11 * t24;
    const double t26 = t10 * t20 + t6 * t22 - t12 * t24;
    const double t27 = t12 * t22 - t11 * t20 + t6 * t24;
    const double t28 = -0.5 * (dt * velocity0 + dt * (dt * (0.5 * gravity0)));
    const double t29 = -0.5 * (dt * velocity1 + dt * (dt * (0.5 * gravity1)));
    const double t30 = -0.5 * (dt * velocity2 + dt * (dt * (0.5 * gravity2)));
    const double t31 = pose4 + pose0 * t28 - pose3 * t29 + pose2 * t30;
    const double t32 = t12 * t20 + t10 * t24 + t11 * t22;
    const double t33 = pose5 + pose3 * t28 + pose0 * t29 - pose1 * t30;
    const double t34 = pose6 - pose2 * t28 + pose1 * t29 + pose0 * t30;
    const double t35 = pose0 * t25 + pose3 * t26 - pose2 * t27 + t6 * t31 - pose1 * t32 - t10 * t33
        + t11 * t34;
    const double t36 = pose7 + pose1 * t28 + pose3 * t30 + pose2 * t29;
    const double t37 = t35 - t12 * t36;
    const double t38 = pose0 * t32 + pose3 * t27 + t12 * t31 + pose1 * t25 + t10 * t34 + t6 * t36 +
        pose2 * t26;
    const double t39 = t38 + t11 * t33;
    const double t40 = pose0 * t27 - t11 * t31 + t12 * t33 + t6 * t34 - pose3 * t32 + pose2 * t25 -
        pose1 * t26;
    const double t41 = t40 - t10 * t36;
    const double t42 = pose0 * t26 - pose2 * t32 + t10 * t31 + pose1 * t27 + t6 * t33 - t11 * t36 -
        pose3 * t25;
    const double t43 = t42 - t12 * t34;
    const double t44 = 0.5 * (2.0 * (t13 * t39 + t15 * t43 - t14 * t41 - t16 * t37));
    const double t45 = pose0 * t19 + pose3 * t21 - pose2 * t23;
    const double t46 = pose0 * t21 + pose1 * t23 - pose3 * t19;
    const double t47 = pose0 * t23 + pose2 * t19 - pose1 * t21;
    const double t48 = pose3 * t23 + pose1 * t19 + pose2 * t21;
    next_pose[0] = t13 * t17;
    next_pose[1] = t16 * t17;
    next_pose[2] = -(t15 * t17);
    next_pose[3] = t14 * t17;
    next_pose[4] = t17 * t37 + t16 * t44;
    next_pose[5] = t17 * t43 - t15 * t44;
    next_pose[6] = t17 * t41 + t14 * t44;
    next_pose[7] = t17 * t39 - t13 * t44;
    next_velocity[0] = velocity0 + dt * gravity0 + (pose0 * t45 + pose3 * t46 - pose2 * t47 + pose1
        * t48);
    next_velocity[1] = velocity1 + dt * gravity1 + (pose0 * t46 - pose3 * t45 + pose2 * t48 + pose1
        * t47);
    next_velocity[2] = velocity2 + dt * gravity2 + (pose2 * t45 - pose1 * t46 + pose0 * t47 + pose3
        * t48);
}

void motorcade_held_transition(const double bias[6], const double rate[3], const double force[3],
        double dt, double turn_turn[9], double position_turn[9], double velocity_turn[9],
        double turn_gyro[9], double position_gyro[9], double velocity_gyro[9],
        double position_accel[9], double velocity_accel[9])
{
    const double bias0 = bias[0], bias1 = bias[1], bias2 = bias[2], bias3 = bias[3];
    const double bias4 = bias[4], bias5 = bias[5];
    const double rate0 = rate[0], rate1 = rate[1], rate2 = rate[2];
    const double force0 = force[0], force1 = force[1], force2 = force[2];
    const double t0 = (rate0 - bias0) * dt;
    const double t1 = dt * (rate1 - bias1);
    const double t2 = dt * (rate2 - bias2);
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const double t4 = 7.052709893347381e-19 * t3;
    const double t5 = t4 + -6.997110409172523e-16;
    const double t6 = t3 * t5 + 5.09682708028848e-13;
    const double t7 = t3 * t6 + -2.691144255102832e-10;
    const double t8 = t3 * t7 + 9.688120033376813e-08;
    const double t9 = t3 * t8 + -2.1701388888777376e-05;
    const double t10 = t3 * t9 + 0.002604166666666568;
    const double t11 = t3 * t10 + -0.12499999999999997;
    const double t12 = t3 * t11 + 1.0;
    const double t13 = t12 * -0.5;
    const double t14 = t12 * t13;
    const double t15 = t3 * 4.1633367917298826e-20;
    const double t16 = t15 + -4.6653082245299195e-17;
    const double t17 = t3 * t16 + 3.9206452611737776e-14;
    const double t18 = t3 * t17 + -2.4464948538103786e-11;
    const double t19 = t3 * t18 + 1.0764577818542514e-08;
    const double t20 = t3 * t19 + -3.1001984126925288e-06;
    const double t21 = t3 * t20 + 0.0005208333333333281;
    const double t22 = t3 * t21 + -0.041666666666666664;
    const double t23 = -0.5 * (1.0 + t3 * t22);
    const double t24 = t1 * t23;
    const double t25 = -0.5 * t24;
    const double t26 = t24 * t25;
    const double t27 = t0 * t23;
    const double t28 = -0.5 * t27;
    const double t29 = t27 * t28;
    const double t30 = t2 * t23;
    const double t31 = -0.5 * t30;
    const double t32 = t30 * t31;
    const double t33 = t24 * t28;
    const double t34 = t12 * t31;
    const double t35 = t25 * t27;
    const double t36 = t13 * t30;
    const double t37 = t12 * t25;
    const double t38 = t13 * t24;
    const double t39 = t27 * t31;
    const double t40 = t28 * t30;
    const double t41 = t12 * t28;
    const double t42 = t25 * t30;
    const double t43 = t24 * t31;
    const double t44 = t13 * t27;
    const double t45 = dt * 0.5;
    const double t46 = dt * (force0 - bias3);
    const double t47 = -0.5 * (t45 * t46);
    const double t48 = dt * (force1 - bias4);
    const double t49 = -0.5 * (t45 * t48);
    const double t50 = dt * (force2 - bias5);
    const double t51 = -0.5 * (t45 * t50);
    const double t52 = t12 * t47 - t30 * t49 + t24 * t51;
    const double t53 = t28 * t52;
    const double t54 = t27 * t47 + t30 * t51 + t24 * t49;
    const double t55 = -0.5 * t54;
    const double t56 = t12 * t55;
    const double t57 = t27 * t49 - t24 * t47 + t12 * t51;
    const double t58 = -0.5 * t57;
    const double t59 = t30 * t58;
    const double t60 = t30 * t47 + t12 * t49 - t27 * t51;
    const double t61 = -0.5 * t60;
    const double t62 = t24 * t61;
    const double t63 = -0.5 * t52;
    const double t64 = t27 * t63;
    const double t65 = t25 * t60;
    const double t66 = t31 * t57;
    const double t67 = t13 * t54;
    const double t68 = t30 * t55;
    const double t69 = t12 * t58;
    const double t70 = t24 * t63;
    const double t71 = t25 * t52;
    const double t72 = t27 * t61;
    const double t73 = t28 * t60;
    const double t74 = t13 * t57;
    const double t75 = t31 * t54;
    const double t76 = t12 * t61;
    const double t77 = t30 * t63;
    const double t78 = t24 * t55;
    const double t79 = t31 * t52;
    const double t80 = t27 * t58;
    const double t81 = t13 * t60;
    const double t82 = t28 * t57;
    const double t83 = t25 * t54;
    const double t84 = t24 * t58;
    const double t85 = t12 * t63;
    const double t86 = t13 * t52;
    const double t87 = t27 * t55;
    const double t88 = t31 * t60;
    const double t89 = t28 * t54;
    const double t90 = t30 * t61;
    const double t91 = t25 * t57;
    const double t92 = t30 * t50;
    const double t93 = t24 * t48;
    const double t94 = t92 + t93;
    const double t95 = t12 * t50;
    const double t96 = t27 * t48;
    const double t97 = t95 + t96;
    const double t98 = t12 * t48;
    const double t99 = t27 * t50;
    const double t100 = t98 - t99;
    const double t101 = t30 * t48;
    const double t102 = t24 * t50;
    const double t103 = t101 - t102;
    const double t104 = t24 * t46;
    const double t105 = t95 - t104;
    const double t106 = t27 * t46;
    const double t107 = t92 + t106;
    const double t108 = t12 * t46;
    const double t109 = t102 + t108;
    const double t110 = t30 * t46;
    const double t111 = t99 - t110;
    const double t112 = t93 + t106;
    const double t113 = t98 + t110;
    const double t114 = t108 - t101;
    const double t115 = t104 - t96;
    const double t116 = dt * (t0 * 2.0);
    const double t117 = t3 * (t3 * (t3 * (t3 * (t4 * t116 + t5 * t116) + t6 * t116) + t7 * t116) +
        t8 * t116);
    const double t118 = t3 * (t3 * (t117 + t9 * t116) + t10 * t116) + t11 * t116;
    const double t119 = t3 * (t3 * (t3 * (t3 * (t15 * t116 + t16 * t116) + t17 * t116) + t18 * t116)
        + t19 * t116);
    const double t120 = -0.5 * (t3 * (t3 * (t119 + t20 * t116) + t21 * t116) + t22 * t116);
    const double t121 = dt * t23;
    const double t122 = t0 * t120 + t121;
    const double t123 = t2 * t120;
    const double t124 = t1 * t120;
    const double t125 = dt * (t1 * 2.0);
    const double t126 = t3 * (t3 * (t3 * (t3 * (t4 * t125 + t5 * t125) + t6 * t125) + t7 * t125) +
        t8 * t125);
    const double t127 = t3 * (t3 * (t126 + t9 * t125) + t10 * t125) + t11 * t125;
    const double t128 = t3 * (t3 * (t3 * (t3 * (t15 * t125 + t16 * t125) + t17 * t125) + t18 * t125)
        + t19 * t125);
    const double t129 = -0.5 * (t3 * (t3 * (t128 + t20 * t125) + t21 * t125) + t22 * t125);
    const double t130 = t0 * t129;
    const double t131 = t2 * t129;
    const double t132 = t121 + t1 * t129;
    const double t133 = dt * (t2 * 2.0);
    const double t134 = t3 * (t3 * (t3 * (t3 * (t4 * t133 + t5 * t133) + t6 * t133) + t7 * t133) +
        t8 * t133);
    const double t135 = t3 * (t3 * (t134 + t9 * t133) + t10 * t133) + t11 * t133;
    const double t136 = t3 * (t3 * (t3 * (t3 * (t15 * t133 + t16 * t133) + t17 * t133) + t18 * t133)
        + t19 * t133);
    const double t137 = -0.5 * (t3 * (t3 * (t136 + t20 * t133) + t21 * t133) + t22 * t133);
    const double t138 = t0 * t137;
    const double t139 = t121 + t2 * t137;
    const double t140 = t1 * t137;
    const double t141 = t49 * t123 - t47 * t118 - t51 * t124;
    const double t142 = t51 * t122 - (t47 * t123 + t49 * t118);
    const double t143 = t47 * t124 - t49 * t122 - t51 * t118;
    const double t144 = t47 * t122 + t51 * t123 + t49 * t124;
    const double t145 = t12 * t141 - t30 * t142 + t24 * t143 + t52 * t118 - t27 * t144 - t60 * t123
        + t57 * t124;
    const double t146 = t49 * t131 - t47 * t127 - t51 * t132;
    const double t147 = t51 * t130 - (t47 * t131 + t49 * t127);
    const double t148 = t47 * t132 - t49 * t130 - t51 * t127;
    const double t149 = t47 * t130 + t51 * t131 + t49 * t132;
    const double t150 = t12 * t146 - t30 * t147 + t24 * t148 + t52 * t127 - t27 * t149 - t60 * t131
        + t57 * t132;
    const double t151 = t49 * t139 - t47 * t135 - t51 * t140;
    const double t152 = t51 * t138 - (t47 * t139 + t49 * t135);
    const double t153 = t47 * t140 - t49 * t138 - t51 * t135;
    const double t154 = t47 * t138 + t51 * t139 + t49 * t140;
    const double t155 = t12 * t151 - t30 * t152 + t24 * t153 + t52 * t135 - t27 * t154 - t60 * t139
        + t57 * t140;
    const double t156 = t12 * t142 - t24 * t144 + t52 * t123 - t27 * t143 + t60 * t118 + t54 * t124
        + t30 * t141;
    const double t157 = t12 * t147 - t24 * t149 + t52 * t131 - t27 * t148 + t60 * t127 + t54 * t132
        + t30 * t146;
    const double t158 = t12 * t152 - t24 * t154 + t52 * t139 - t27 * t153 + t60 * t135 + t54 * t140
        + t30 * t151;
    const double t159 = t12 * t143 - t52 * t124 + t60 * t122 + t57 * t118 - t30 * t144 - t24 * t141
        + t27 * t142;
    const double t160 = t12 * t148 - t52 * t132 + t60 * t130 + t57 * t127 - t30 * t149 - t24 * t146
        + t27 * t147;
    const double t161 = t12 * t153 - t52 * t140 + t60 * t138 + t57 * t135 - t30 * t154 - t24 * t151
        + t27 * t152;
    const double t162 = -0.5 * (dt * t45);
    const double t163 = t30 * t162;
    const double t164 = t30 * t163;
    const double t165 = t12 * t162;
    const double t166 = t12 * t165;
    const double t167 = t24 * t162;
    const double t168 = t24 * t167;
    const double t169 = t27 * t162;
    const double t170 = t27 * t169;
    const double t171 = t12 * t163;
    const double t172 = t30 * t165;
    const double t173 = t24 * t169;
    const double t174 = t27 * t167;
    const double t175 = t12 * t167;
    const double t176 = t30 * t169;
    const double t177 = t24 * t165;
    const double t178 = t27 * t163;
    const double t179 = t12 * t169;
    const double t180 = t24 * t163;
    const double t181 = t27 * t165;
    const double t182 = t30 * t167;
    const double t183 = dt * t30;
    const double t184 = t30 * t183;
    const double t185 = dt * t12;
    const double t186 = t12 * t185;
    const double t187 = t184 - t186;
    const double t188 = dt * t24;
    const double t189 = t24 * t188;
    const double t190 = dt * t27;
    const double t191 = t27 * t190;
    const double t192 = t12 * t183 + t30 * t185;
    const double t193 = t24 * t190;
    const double t194 = t27 * t188;
    const double t195 = t12 * t188;
    const double t196 = t30 * t190;
    const double t197 = t24 * t185;
    const double t198 = t27 * t183;
    const double t199 = t12 * t190;
    const double t200 = t30 * t188;
    const double t201 = t24 * t183;
    const double t202 = t27 * t185;
    turn_turn[0] = -2.0 * (t14 - t26 + t29 - t32);
    turn_turn[1] = -2.0 * (t33 - t34 + t35 - t36);
    turn_turn[2] = -2.0 * (t37 + t38 + t39 + t40);
    turn_turn[3] = -2.0 * (t35 + (t33 + (t34 + t36)));
    turn_turn[4] = -(-2.0 * (t29 + (t32 - t14 - t26)));
    turn_turn[5] = -(-2.0 * (t41 - t42 - t43 + t44));
    turn_turn[6] = -2.0 * (t39 + (t40 - t37) - t38);
    turn_turn[7] = -2.0 * (t43 + (t44 + (t41 + t42)));
    turn_turn[8] = -2.0 * (t14 + t32 - t29 - t26);
    position_turn[0] = -2.0 * (t53 - (t56 + t59 + t62) + t64 - t65 - t66 - t67);
    position_turn[1] = -2.0 * (t68 - t69 + t70 + t71 + t72 + t73 - t74 + t75);
    position_turn[2] = -2.0 * (t76 + t77 - t78 + t79 + t80 + t81 + t82 - t83);
    position_turn[3] = -2.0 * (t74 + (t73 + (t72 + (t71 + (t69 + t70))) - t75 - t68));
    position_turn[4] = -2.0 * (t65 + (t62 - t56 - t53 - t64) - t67 - t59 - t66);
    position_turn[5] = -2.0 * (t84 - t85 - t86 + t87 + t88 + t89 + t90 + t91);
    position_turn[6] = -2.0 * (t83 + (t80 + (t78 + (t77 + (t82 + (t79 - t76 - t81))))));
    position_turn[7] = -2.0 * (t84 + (t90 + (t91 + (t88 + (t85 + t86)))) - t87 - t89);
    position_turn[8] = -2.0 * (t59 + (t66 - (t65 + (t53 + t56))) - t62 - t64 - t67);
    velocity_turn[0] = t12 * t94 + t30 * t97 + t24 * t100 + t27 * t103;
    velocity_turn[1] = t12 * t105 - t30 * t107 - t24 * t109 + t27 * t111;
    velocity_turn[2] = t24 * t112 - (t12 * t113 + t30 * t114) + t27 * t115;
    velocity_turn[3] = t30 * t94 - t12 * t97 + t24 * t103 - t27 * t100;
    velocity_turn[4] = t30 * t105 + t12 * t107 + t24 * t111 + t27 * t109;
    velocity_turn[5] = t12 * t114 - t30 * t113 + t24 * t115 - t27 * t112;
    velocity_turn[6] = t12 * t100 - (t27 * t97 + t24 * t94) + t30 * t103;
    velocity_turn[7] = t27 * t107 - t24 * t105 - t12 * t109 + t30 * t111;
    velocity_turn[8] = t27 * t114 + t24 * t113 + t12 * t112 + t30 * t115;
    turn_gyro[0] = -2.0 * (t27 * t118 - (t12 * t122 + t24 * t123) + t30 * t124);
    turn_gyro[1] = -2.0 * (t27 * t127 - (t12 * t130 + t24 * t131) + t30 * t132);
    turn_gyro[2] = -2.0 * (t27 * t135 - (t12 * t138 + t24 * t139) + t30 * t140);
    turn_gyro[3] = -(-2.0 * (t12 * t124 + t30 * t122 - t24 * t118 - t27 * t123));
    turn_gyro[4] = -(-2.0 * (t12 * t132 + t30 * t130 - t24 * t127 - t27 * t131));
    turn_gyro[5] = -(-2.0 * (t12 * t140 + t30 * t138 - t24 * t135 - t27 * t139));
    turn_gyro[6] = -2.0 * (t30 * t118 - t12 * t123 - t27 * t124 + t24 * t122);
    turn_gyro[7] = -2.0 * (t30 * t127 - t12 * t131 - t27 * t132 + t24 * t130);
    turn_gyro[8] = -2.0 * (t30 * t135 - t12 * t139 - t27 * t140 + t24 * t138);
    position_gyro[0] = -2.0 * (t145 + t54 * t122);
    position_gyro[1] = -2.0 * (t150 + t54 * t130);
    position_gyro[2] = -2.0 * (t155 + t54 * t138);
    position_gyro[3] = -2.0 * (t156 - t57 * t122);
    position_gyro[4] = -2.0 * (t157 - t57 * t130);
    position_gyro[5] = -2.0 * (t158 - t57 * t138);
    position_gyro[6] = -2.0 * (t159 + t54 * t123);
    position_gyro[7] = -2.0 * (t160 + t54 * t131);
    position_gyro[8] = -2.0 * (t161 + t54 * t139);
    velocity_gyro[0] = 0.0;
    velocity_gyro[1] = 0.0;
    velocity_gyro[2] = 0.0;
    velocity_gyro[3] = 0.0;
    velocity_gyro[4] = 0.0;
    velocity_gyro[5] = 0.0;
    velocity_gyro[6] = 0.0;
    velocity_gyro[7] = 0.0;
    velocity_gyro[8] = 0.0;
    position_accel[0] = -2.0 * (t164 - t166 + t168 - t170);
    position_accel[1] = -2.0 * (t171 + t172 - t173 - t174);
    position_accel[2] = -(-2.0 * (t175 + t176 + t177 + t178));
    position_accel[3] = -(-2.0 * (t172 + (t174 + (t171 + t173))));
    position_accel[4] = -2.0 * (t164 + (t170 - (t166 + t168)));
    position_accel[5] = -2.0 * (t179 - t180 + t181 - t182);
    position_accel[6] = -2.0 * (t177 + (t175 - t176) - t178);
    position_accel[7] = -(-2.0 * (t181 + (t180 + (t179 + t182))));
    position_accel[8] = -2.0 * (t170 + (t168 - (t164 + t166)));
    velocity_accel[0] = t187 + t189 - t191;
    velocity_accel[1] = t192 - t193 - t194;
    velocity_accel[2] = -(t195 + t196 + t197 + t198);
    velocity_accel[3] = -(t194 + (t192 + t193));
    velocity_accel[4] = t191 + (t187 - t189);
    velocity_accel[5] = t199 - t200 - t201 + t202;
    velocity_accel[6] = t195 + (t197 - t198) - t196;
    velocity_accel[7] = -(t200 + (t199 + (t201 + t202)));
    velocity_accel[8] = t189 + t191 - t186 - t184;
}

void motorcade_gravity(const double gravity_rotor[4], double size, double gravity[3])
{
    const double gravity_rotor0 = gravity_rotor[0], gravity_rotor1 = gravity_rotor[1],
        gravity_rotor2 = gravity_rotor[2], gravity_rotor3 = gravity_rotor[3];
    const double t0 = gravity_rotor2 * size;
    const double t1 = size * gravity_rotor1;
    const double t2 = size * gravity_rotor0;
    const double t3 = size * gravity_rotor3;
    const double t4 = t0 * gravity_rotor0 - t1 * gravity_rotor3 + gravity_rotor2 * t2 -
        gravity_rotor1 * t3;
    const double t5 = t0 * gravity_rotor3 + gravity_rotor0 * t1 + gravity_rotor2 * t3 +
        gravity_rotor1 * t2;
    const double t6 = gravity_rotor2 * t0 + gravity_rotor1 * t1 - gravity_rotor0 * t2 -
        gravity_rotor3 * t3;
    gravity[0] = t4;
    gravity[1] = -t5;
    gravity[2] = t6;
}

void motorcade_gravity_effect(const double pose[8], const double gravity_rotor[4], double size,
        double dt, double velocity_tilt[6])
{
    const double pose0 = pose[0], pose1 = pose[1], pose2 = pose[2], pose3 = pose[3];
    const double gravity_rotor0 = gravity_rotor[0], gravity_rotor1 = gravity_rotor[1],
        gravity_rotor2 = gravity_rotor[2], gravity_rotor3 = gravity_rotor[3];
    const double t0 = -0.5 * gravity_rotor0;
    const double t1 = size * t0;
    const double t2 = gravity_rotor1 * size;
    const double t3 = -0.5 * gravity_rotor3;
    const double t4 = size * t3;
    const double t5 = size * gravity_rotor2;
    const double t6 = gravity_rotor1 * -0.5;
    const double t7 = size * t6;
    const double t8 = size * gravity_rotor0;
    const double t9 = gravity_rotor1 * t1 + t0 * t2 - (gravity_rotor2 * t4 + t3 * t5) +
        (gravity_rotor0 * t7 + t6 * t8);
    const double t10 = -0.5 * gravity_rotor2;
    const double t11 = size * t10;
    const double t12 = size * gravity_rotor3;
    const double t13 = t9 - (gravity_rotor3 * t11 + t10 * t12);
    const double t14 = gravity_rotor0 * t4;
    const double t15 = t5 * t6;
    const double t16 = t1 * gravity_rotor3;
    const double t17 = t2 * t10;
    const double t18 = t3 * t8;
    const double t19 = gravity_rotor2 * t7;
    const double t20 = gravity_rotor1 * t11;
    const double t21 = t0 * t12;
    const double t22 = t14 + t15 + (t16 + t17) + (t18 + t19) + (t20 + t21);
    const double t23 = gravity_rotor3 * t4;
    const double t24 = t5 * t10;
    const double t25 = gravity_rotor0 * t1;
    const double t26 = t2 * t6;
    const double t27 = t3 * t12;
    const double t28 = gravity_rotor2 * t11;
    const double t29 = t0 * t8;
    const double t30 = gravity_rotor1 * t7;
    const double t31 = t23 - t24 - (t25 - t26) + (t27 - t28) - (t29 - t30);
    const double t32 = pose2 * t13 - (pose0 * t22 + pose3 * t31);
    const double t33 = pose0 * t31 - t13 * pose1 - t22 * pose3;
    const double t34 = pose0 * t13 + pose2 * t22 + t31 * pose1;
    const double t35 = t22 * pose1 - t13 * pose3 - pose2 * t31;
    const double t36 = gravity_rotor1 * t4 + t2 * t3 + (t1 * gravity_rotor2 + t0 * t5) +
        (gravity_rotor0 * t11 + t8 * t10);
    const double t37 = t36 + (gravity_rotor3 * t7 + t6 * t12);
    const double t38 = t23 - t26 - (t25 - t24) - (t29 - t28) + (t27 - t30);
    const double t39 = t16 - t15 + (t14 - t17) + (t21 - t19) + (t18 - t20);
    const double t40 = pose2 * t37 - (pose0 * t38 - pose3 * t39);
    const double t41 = pose0 * t39 + pose1 * t37 + pose3 * t38;
    const double t42 = pose0 * t37 + pose2 * t38 - pose1 * t39;
    const double t43 = pose1 * t38 - pose3 * t37 + pose2 * t39;
    velocity_tilt[0] = dt * (pose0 * t32 - pose3 * t33 + pose2 * t34 - pose1 * t35);
    velocity_tilt[1] = dt * (pose0 * t40 + pose3 * t41 + pose2 * t42 - pose1 * t43);
    velocity_tilt[2] = dt * (pose3 * t32 + pose0 * t33 - pose2 * t35 - pose1 * t34);
    velocity_tilt[3] = dt * (pose3 * t40 - pose0 * t41 - pose2 * t43 - pose1 * t42);
    velocity_tilt[4] = dt * (pose1 * t33 - pose2 * t32 + pose0 * t34 - pose3 * t35);
    velocity_tilt[5] = dt * (pose0 * t42 - (pose1 * t41 + pose2 * t40) - pose3 * t43);
}
