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
    const double t21 = t3 * (t3 * (t3 * 1.8050378425951147e-20 + -8.194997200664283e-18) +
        2.8112228749921305e-15);
    const double t22 = t3 * (t3 * (t21 + -7.64715120995758e-13) + 1.6059043443298548e-10) +
        -2.5052108378488887e-08;
    const double t23 = t3 * (t3 * (t3 * t22 + 2.755731922392432e-06) + -0.00019841269841269633) +
        0.008333333333333333;
    const double t24 = 0.16666666666666666 - t3 * t23;
    const double t25 = force2 - bias5;
    const double t26 = force1 - bias4;
    const double t27 = 0.5 * ((t1 * t25 - t2 * t26) * 2.0);
    const double t28 = t3 * (t3 * -3.7988330109729093e-19 + 1.5573737959804194e-16) +
        -4.779129412912699e-14;
    const double t29 = t3 * (t3 * (t3 * t28 + 1.14707308096133e-11) + -2.087675664605937e-09) +
        2.755731922010282e-07;
    const double t30 = 0.041666666666666664 - t3 * (t3 * (t3 * t29 + -2.4801587301570486e-05) +
        0.0013888888888888876);
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
    const double t8 = t7 * (4.1633367917298826e-20 * t7 + -4.6653082245299195e-17) +
        3.9206452611737776e-14;
    const double t9 = t7 * (t7 * (t7 * t8 + -2.4464948538103786e-11) + 1.0764577818542514e-08) +
        -3.1001984126925288e-06;
    const double t10 = 1.0 + t7 * (t7 * (t7 * t9 + 0.0005208333333333281) + -0.041666666666666664);
    const double t11 = t10 * (0.5 * t10);
    const double t12 = t3 + t6;
    const double t13 = 1.0 - t11 * t12;
    const double t14 = t7 * (t7 * (t7 * 7.052709893347381e-19 + -6.997110409172523e-16) +
        5.09682708028848e-13);
    const double t15 = t7 * (t7 * (t14 + -2.691144255102832e-10) + 9.688120033376813e-08) +
        -2.1701388888777376e-05;
    const double t16 = t10 * (1.0 + t7 * (t7 * (t7 * t15 + 0.002604166666666568) +
        -0.12499999999999997));
    const double t17 = t5 * t16;
    const double t18 = t0 * t2;
    const double t19 = t11 * t18;
    const double t20 = t17 + t19;
    const double t21 = t0 * t5;
    const double t22 = t11 * t21;
    const double t23 = t2 * t16;
    const double t24 = t22 - t23;
    const double t25 = t19 - t17;
    const double t26 = t1 + t6;
    const double t27 = 1.0 - t11 * t26;
    const double t28 = t0 * t16;
    const double t29 = t2 * t5;
    const double t30 = t11 * t29;
    const double t31 = t28 + t30;
    const double t32 = t22 + t23;
    const double t33 = t30 - t28;
    const double t34 = 1.0 - t4 * t11;
    const double t35 = dt * dt;
    const double t36 = force2 - bias5;
    const double t37 = t7 * (t7 * (t7 * 1.8050378425951147e-20 + -8.194997200664283e-18) +
        2.8112228749921305e-15);
    const double t38 = t7 * (t7 * (t37 + -7.64715120995758e-13) + 1.6059043443298548e-10) +
        -2.5052108378488887e-08;
    const double t39 = t7 * (t7 * (t7 * t38 + 2.755731922392432e-06) + -0.00019841269841269633) +
        0.008333333333333333;
    const double t40 = 0.16666666666666666 - t7 * t39;
    const double t41 = force1 - bias4;
    const double t42 = t0 * t41;
    const double t43 = force0 - bias3;
    const double t44 = t2 * t43;
    const double t45 = 0.5 * ((t42 - t44) * 2.0);
    const double t46 = t40 * t45;
    const double t47 = t7 * (t7 * -3.7988330109729093e-19 + 1.5573737959804194e-16) +
        -4.779129412912699e-14;
    const double t48 = t7 * (t7 * (t7 * t47 + 1.14707308096133e-11) + -2.087675664605937e-09) +
        2.755731922010282e-07;
    const double t49 = t7 * (t7 * t48 + -2.4801587301570486e-05) + 0.0013888888888888876;
    const double t50 = 0.041666666666666664 - t7 * t49;
    const double t51 = t5 * t43;
    const double t52 = t0 * t36;
    const double t53 = 0.5 * (2.0 * (t51 - t52));
    const double t54 = t2 * t36;
    const double t55 = t5 * t41;
    const double t56 = 0.5 * (2.0 * (t54 - t55));
    const double t57 = 0.5 * (2.0 * (t0 * t53 - t2 * t56));
    const double t58 = t35 * (0.5 * t36 + t46 + t50 * t57);
    const double t59 = t40 * t53;
    const double t60 = 0.5 * (2.0 * (t5 * t56 - t0 * t45));
    const double t61 = t35 * (0.5 * t41 + t59 + t50 * t60);
    const double t62 = t40 * t56;
    const double t63 = 0.5 * (2.0 * (t2 * t45 - t5 * t53));
    const double t64 = t35 * (0.5 * t43 + t62 + t50 * t63);
    const double t65 = dt * (t36 + t11 * t45 + t40 * t57);
    const double t66 = dt * (t41 + t11 * t53 + t40 * t60);
    const double t67 = dt * (t43 + t11 * t56 + t40 * t63);
    const double t68 = dt * t40;
    const double t69 = t12 * t68 - dt;
    const double t70 = dt * t11;
    const double t71 = t5 * t70;
    const double t72 = t18 * t68;
    const double t73 = -(t71 + t72);
    const double t74 = t2 * t70;
    const double t75 = t21 * t68;
    const double t76 = t74 - t75;
    const double t77 = t71 - t72;
    const double t78 = t26 * t68 - dt;
    const double t79 = t0 * t70;
    const double t80 = t29 * t68;
    const double t81 = -(t79 + t80);
    const double t82 = -(t74 + t75);
    const double t83 = t79 - t80;
    const double t84 = t4 * t68 - dt;
    const double t85 = dt * t35;
    const double t86 = t5 * t36;
    const double t87 = t2 * t41;
    const double t88 = t86 + t87;
    const double t89 = t39 * 3.0 - t50;
    const double t90 = t49 * 4.0 - t39;
    const double t91 = t56 * t89 + t63 * t90;
    const double t92 = t50 * t88 + t0 * t91;
    const double t93 = t53 * t89 + t60 * t90;
    const double t94 = t36 * t40 + t45 * t50;
    const double t95 = t0 * t93 - (t94 + t42 * t50);
    const double t96 = t40 * t41 + t50 * t53;
    const double t97 = t45 * t89 + t57 * t90;
    const double t98 = t96 - t50 * t52 + t0 * t97;
    const double t99 = t94 - t44 * t50 + t2 * t91;
    const double t100 = t0 * t43;
    const double t101 = t86 + t100;
    const double t102 = t50 * t101 + t2 * t93;
    const double t103 = t40 * t43 + t50 * t56;
    const double t104 = t2 * t97 - (t103 + t50 * t54);
    const double t105 = t5 * t91 - (t96 + t50 * t51);
    const double t106 = t103 - t50 * t55 + t5 * t93;
    const double t107 = t87 + t100;
    const double t108 = t50 * t107 + t5 * t97;
    const double t109 = 2.0 * t50 - t40;
    const double t110 = t56 * t109 + t63 * t89;
    const double t111 = t40 * t88 + t0 * t110;
    const double t112 = t53 * t109 + t60 * t89;
    const double t113 = t46 + t11 * t36;
    const double t114 = t0 * t112 - (t113 + t40 * t42);
    const double t115 = t59 + t11 * t41;
    const double t116 = t45 * t109 + t57 * t89;
    const double t117 = t115 - t40 * t52 + t0 * t116;
    const double t118 = t113 - t40 * t44 + t2 * t110;
    const double t119 = t40 * t101 + t2 * t112;
    const double t120 = t62 + t11 * t43;
    const double t121 = t2 * t116 - (t120 + t40 * t54);
    const double t122 = t5 * t110 - (t115 + t40 * t51);
    const double t123 = t120 - t40 * t55 + t5 * t112;
    const double t124 = t40 * t107 + t5 * t116;
    const double t125 = dt * (dt * -0.5);
    const double t126 = t35 * (t50 - t40);
    const double t127 = t18 * t126;
    const double t128 = t35 * (t11 - t40);
    const double t129 = t5 * t128;
    const double t130 = t2 * t128;
    const double t131 = t21 * t126;
    const double t132 = t29 * t126;
    const double t133 = t0 * t128;
    turn_turn[0] = t13;
    turn_turn[1] = t20;
    turn_turn[2] = t24;
    turn_turn[3] = t25;
    turn_turn[4] = t27;
    turn_turn[5] = t31;
    turn_turn[6] = t32;
    turn_turn[7] = t33;
    turn_turn[8] = t34;
    position_turn[0] = t24 * t61 - t20 * t58;
    position_turn[1] = t13 * t58 - t24 * t64;
    position_turn[2] = t20 * t64 - t13 * t61;
    position_turn[3] = t31 * t61 - t27 * t58;
    position_turn[4] = t25 * t58 - t31 * t64;
    position_turn[5] = t27 * t64 - t25 * t61;
    position_turn[6] = t34 * t61 - t33 * t58;
    position_turn[7] = t32 * t58 - t34 * t64;
    position_turn[8] = t33 * t64 - t32 * t61;
    velocity_turn[0] = t24 * t66 - t20 * t65;
    velocity_turn[1] = t13 * t65 - t24 * t67;
    velocity_turn[2] = t20 * t67 - t13 * t66;
    velocity_turn[3] = t31 * t66 - t27 * t65;
    velocity_turn[4] = t25 * t65 - t31 * t67;
    velocity_turn[5] = t27 * t67 - t25 * t66;
    velocity_turn[6] = t34 * t66 - t33 * t65;
    velocity_turn[7] = t32 * t65 - t34 * t67;
    velocity_turn[8] = t33 * t67 - t32 * t66;
    turn_gyro[0] = t69;
    turn_gyro[1] = t73;
    turn_gyro[2] = t76;
    turn_gyro[3] = t77;
    turn_gyro[4] = t78;
    turn_gyro[5] = t81;
    turn_gyro[6] = t82;
    turn_gyro[7] = t83;
    turn_gyro[8] = t84;
    position_gyro[0] = -(t85 * (t13 * t92 + t20 * t95 + t24 * t98));
    position_gyro[1] = -(t85 * (t13 * t99 + t20 * t102 + t24 * t104));
    position_gyro[2] = -(t85 * (t13 * t105 + t20 * t106 + t24 * t108));
    position_gyro[3] = -(t85 * (t25 * t92 + t27 * t95 + t31 * t98));
    position_gyro[4] = -(t85 * (t25 * t99 + t27 * t102 + t31 * t104));
    position_gyro[5] = -(t85 * (t25 * t105 + t27 * t106 + t31 * t108));
    position_gyro[6] = -(t85 * (t32 * t92 + t33 * t95 + t34 * t98));
    position_gyro[7] = -(t85 * (t32 * t99 + t33 * t102 + t34 * t104));
    position_gyro[8] = -(t85 * (t32 * t105 + t33 * t106 + t34 * t108));
    velocity_gyro[0] = -(t35 * (t13 * t111 + t20 * t114 + t24 * t117));
    velocity_gyro[1] = -(t35 * (t13 * t118 + t20 * t119 + t24 * t121));
    velocity_gyro[2] = -(t35 * (t13 * t122 + t20 * t123 + t24 * t124));
    velocity_gyro[3] = -(t35 * (t25 * t111 + t27 * t114 + t31 * t117));
    velocity_gyro[4] = -(t35 * (t25 * t118 + t27 * t119 + t31 * t121));
    velocity_gyro[5] = -(t35 * (t25 * t122 + t27 * t123 + t31 * t124));
    velocity_gyro[6] = -(t35 * (t32 * t111 + t33 * t114 + t34 * t117));
    velocity_gyro[7] = -(t35 * (t32 * t118 + t33 * t119 + t34 * t121));
    velocity_gyro[8] = -(t35 * (t32 * t122 + t33 * t123 + t34 * t124));
    position_accel[0] = t125 - t12 * t126;
    position_accel[1] = t127 - t129;
    position_accel[2] = t130 + t131;
    position_accel[3] = t127 + t129;
    position_accel[4] = t125 - t26 * t126;
    position_accel[5] = t132 - t133;
    position_accel[6] = t131 - t130;
    position_accel[7] = t132 + t133;
    position_accel[8] = t125 - t4 * t126;
    velocity_accel[0] = t69;
    velocity_accel[1] = t73;
    velocity_accel[2] = t76;
    velocity_accel[3] = t77;
    velocity_accel[4] = t78;
    velocity_accel[5] = t81;
    velocity_accel[6] = t82;
    velocity_accel[7] = t83;
    velocity_accel[8] = t84;
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
    const double t1 = t0 * t0;
    const double t2 = dt * (rate1 - bias1);
    const double t3 = t2 * t2;
    const double t4 = t1 + t3;
    const double t5 = dt * (rate2 - bias2);
    const double t6 = t5 * t5;
    const double t7 = t4 + t6;
    const double t8 = t7 * (4.1633367917298826e-20 * t7 + -4.6653082245299195e-17) +
        3.9206452611737776e-14;
    const double t9 = t7 * (t7 * (t7 * t8 + -2.4464948538103786e-11) + 1.0764577818542514e-08) +
        -3.1001984126925288e-06;
    const double t10 = 1.0 + t7 * (t7 * (t7 * t9 + 0.0005208333333333281) + -0.041666666666666664);
    const double t11 = t10 * (0.5 * t10);
    const double t12 = t3 + t6;
    const double t13 = 1.0 - t11 * t12;
    const double t14 = t7 * (t7 * (t7 * 7.052709893347381e-19 + -6.997110409172523e-16) +
        5.09682708028848e-13);
    const double t15 = t7 * (t7 * (t14 + -2.691144255102832e-10) + 9.688120033376813e-08) +
        -2.1701388888777376e-05;
    const double t16 = t10 * (1.0 + t7 * (t7 * (t7 * t15 + 0.002604166666666568) +
        -0.12499999999999997));
    const double t17 = t5 * t16;
    const double t18 = t0 * t2;
    const double t19 = t11 * t18;
    const double t20 = t17 + t19;
    const double t21 = t0 * t5;
    const double t22 = t11 * t21;
    const double t23 = t2 * t16;
    const double t24 = t22 - t23;
    const double t25 = t19 - t17;
    const double t26 = t1 + t6;
    const double t27 = 1.0 - t11 * t26;
    const double t28 = t0 * t16;
    const double t29 = t2 * t5;
    const double t30 = t11 * t29;
    const double t31 = t28 + t30;
    const double t32 = t22 + t23;
    const double t33 = t30 - t28;
    const double t34 = 1.0 - t4 * t11;
    const double t35 = 0.5 * dt;
    const double t36 = dt * (force2 - bias5);
    const double t37 = t35 * t36;
    const double t38 = dt * (force1 - bias4);
    const double t39 = t35 * t38;
    const double t40 = dt * (force0 - bias3);
    const double t41 = t35 * t40;
    const double t42 = t7 * (t7 * (t7 * 1.8050378425951147e-20 + -8.194997200664283e-18) +
        2.8112228749921305e-15);
    const double t43 = t7 * (t7 * (t42 + -7.64715120995758e-13) + 1.6059043443298548e-10) +
        -2.5052108378488887e-08;
    const double t44 = t7 * (t7 * (t7 * t43 + 2.755731922392432e-06) + -0.00019841269841269633) +
        0.008333333333333333;
    const double t45 = dt * (0.16666666666666666 - t7 * t44);
    const double t46 = dt * t11;
    const double t47 = t5 * t46;
    const double t48 = t18 * t45;
    const double t49 = t2 * t46;
    const double t50 = t21 * t45;
    const double t51 = t0 * t46;
    const double t52 = t29 * t45;
    const double t53 = dt * (dt * -0.5);
    turn_turn[0] = t13;
    turn_turn[1] = t20;
    turn_turn[2] = t24;
    turn_turn[3] = t25;
    turn_turn[4] = t27;
    turn_turn[5] = t31;
    turn_turn[6] = t32;
    turn_turn[7] = t33;
    turn_turn[8] = t34;
    position_turn[0] = t24 * t39 - t20 * t37;
    position_turn[1] = t13 * t37 - t24 * t41;
    position_turn[2] = t20 * t41 - t13 * t39;
    position_turn[3] = t31 * t39 - t27 * t37;
    position_turn[4] = t25 * t37 - t31 * t41;
    position_turn[5] = t27 * t41 - t25 * t39;
    position_turn[6] = t34 * t39 - t33 * t37;
    position_turn[7] = t32 * t37 - t34 * t41;
    position_turn[8] = t33 * t41 - t32 * t39;
    velocity_turn[0] = t24 * t38 - t20 * t36;
    velocity_turn[1] = t13 * t36 - t24 * t40;
    velocity_turn[2] = t20 * t40 - t13 * t38;
    velocity_turn[3] = t31 * t38 - t27 * t36;
    velocity_turn[4] = t25 * t36 - t31 * t40;
    velocity_turn[5] = t27 * t40 - t25 * t38;
    velocity_turn[6] = t34 * t38 - t33 * t36;
    velocity_turn[7] = t32 * t36 - t34 * t40;
    velocity_turn[8] = t33 * t40 - t32 * t38;
    turn_gyro[0] = t12 * t45 - dt;
    turn_gyro[1] = -(t47 + t48);
    turn_gyro[2] = t49 - t50;
    turn_gyro[3] = t47 - t48;
    turn_gyro[4] = t26 * t45 - dt;
    turn_gyro[5] = -(t51 + t52);
    turn_gyro[6] = -(t49 + t50);
    turn_gyro[7] = t51 - t52;
    turn_gyro[8] = t4 * t45 - dt;
    position_gyro[0] = 0.0;
    position_gyro[1] = 0.0;
    position_gyro[2] = 0.0;
    position_gyro[3] = 0.0;
    position_gyro[4] = 0.0;
    position_gyro[5] = 0.0;
    position_gyro[6] = 0.0;
    position_gyro[7] = 0.0;
    position_gyro[8] = 0.0;
    velocity_gyro[0] = 0.0;
    velocity_gyro[1] = 0.0;
    velocity_gyro[2] = 0.0;
    velocity_gyro[3] = 0.0;
    velocity_gyro[4] = 0.0;
    velocity_gyro[5] = 0.0;
    velocity_gyro[6] = 0.0;
    velocity_gyro[7] = 0.0;
    velocity_gyro[8] = 0.0;
    position_accel[0] = t13 * t53;
    position_accel[1] = t20 * t53;
    position_accel[2] = t24 * t53;
    position_accel[3] = t25 * t53;
    position_accel[4] = t27 * t53;
    position_accel[5] = t31 * t53;
    position_accel[6] = t32 * t53;
    position_accel[7] = t33 * t53;
    position_accel[8] = t34 * t53;
    velocity_accel[0] = -(dt * t13);
    velocity_accel[1] = -(dt * t20);
    velocity_accel[2] = -(dt * t24);
    velocity_accel[3] = -(dt * t25);
    velocity_accel[4] = -(dt * t27);
    velocity_accel[5] = -(dt * t31);
    velocity_accel[6] = -(dt * t32);
    velocity_accel[7] = -(dt * t33);
    velocity_accel[8] = -(dt * t34);
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
