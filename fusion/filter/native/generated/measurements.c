/*
 * The filter's measurements.
 * Written by `python -m motorcade.fusion.filter.model`; edit fusion/filter/model.
 */

#include "model.h"

#include <math.h>

void motorcade_retract(const double pose[8], const double error[6], double out[8])
{
    const double pose0 = pose[0], pose1 = pose[1], pose2 = pose[2], pose3 = pose[3];
    const double pose4 = pose[4], pose5 = pose[5], pose6 = pose[6], pose7 = pose[7];
    const double error0 = error[0], error1 = error[1], error2 = error[2], error3 = error[3];
    const double error4 = error[4], error5 = error[5];
    const double t0 = -0.5 * error2;
    const double t1 = -0.5 * error1;
    const double t2 = -0.5 * error0;
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const double t4 = sqrt(t3);
    const double t5 = floor(0.3183098861837907 * t4 + 0.5);
    const double t6 = 1.0 - 2.0 * (t5 - floor(0.5 * t5) * 2.0);
    const double t7 = t4 - t5 * 3.1415926218032837 - t5 * 3.1786509424591713e-08 - t5 *
        1.2246467202362698e-16;
    const double t8 = t7 - t5 * 7.891108333126411e-24;
    const double t9 = t8 * t8;
    const double t10 = t9 * (t9 * (4.608909074888812e-14 * t9 + -1.146289561457958e-11) +
        2.0876561604575935e-09);
    const double t11 = t9 * (t9 * (t10 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
        -0.0013888888888772708;
    const double t12 = t6 * (1.0 + t9 * (t9 * (t9 * t11 + 0.041666666666663875) +
        -0.4999999999999997));
    const _Bool t13 = (t5 < 0.5);
    const double t14 = t9 * (t9 * (t9 * 2.721539074015491e-15 + -7.643023238169083e-13) +
        1.6058940754212953e-10);
    const double t15 = t9 * (t9 * (t14 + -2.505210688815946e-08) + 2.755731921120387e-06) +
        -0.00019841269841208527;
    const double t16 = 1.0 + t9 * (t9 * (t9 * t15 + 0.008333333333333186) + -0.16666666666666666);
    const double t17 = (t13 ? t16 : t16 * (t6 * t8) / fmax(1.0, t4));
    const double t18 = t0 * t17;
    const double t19 = t1 * t17;
    const double t20 = t2 * t17;
    const double t21 = pose0 * t12 - pose3 * t18 - pose2 * t19 - pose1 * t20;
    const double t22 = pose0 * t18 + t12 * pose3 - t19 * pose1 + pose2 * t20;
    const double t23 = pose3 * t20 - pose0 * t19 - t12 * pose2 - t18 * pose1;
    const double t24 = pose0 * t20 - t18 * pose2 + t12 * pose1 + pose3 * t19;
    const double t25 = 1.5 - 0.5 * (t21 * t21 + t22 * t22 + t23 * t23 + t24 * t24);
    const double t26 = -0.5 * error3;
    const double t27 = t9 * (t9 * (t9 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
        9.635366495989451e-10);
    const double t28 = t9 * (t9 * (t27 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
        -0.0005952380952367574;
    const double t29 = (t13 ? -0.16666666666666666 + t9 * (t9 * t28 + 0.01666666666666651) : (t12 -
        t17) / (2.0 * fmax(1.0, t3)));
    const double t30 = -0.5 * error5;
    const double t31 = -0.5 * error4;
    const double t32 = 2.0 * (t2 * t26 + (t0 * t30 + t1 * t31));
    const double t33 = t29 * t32;
    const double t34 = t17 * t26 + t2 * t33;
    const double t35 = t17 * t31 + t1 * t33;
    const double t36 = t17 * t30 + t0 * t33;
    const double t37 = t32 * (-0.5 * t17);
    const double t38 = pose0 * t34 + pose3 * t35 - pose2 * t36 + t12 * pose4 + pose1 * t37 - t18 *
        pose5 + t19 * pose6;
    const double t39 = t38 - t20 * pose7;
    const double t40 = pose3 * t36 - pose0 * t37 + t20 * pose4 + pose1 * t34 + t18 * pose6 + t12 *
        pose7 + pose2 * t35;
    const double t41 = t40 + t19 * pose5;
    const double t42 = pose0 * t36 - t19 * pose4 + t20 * pose5 + t12 * pose6 + pose3 * t37 + pose2 *
        t34 - pose1 * t35;
    const double t43 = t42 - t18 * pose7;
    const double t44 = pose0 * t35 + pose2 * t37 + t18 * pose4 + pose1 * t36 + t12 * pose5 - t19 *
        pose7 - pose3 * t34;
    const double t45 = t44 - t20 * pose6;
    const double t46 = 0.5 * (2.0 * (t21 * t41 + t23 * t45 - t22 * t43 - t24 * t39));
    out[0] = t21 * t25;
    out[1] = t24 * t25;
    out[2] = -(t23 * t25);
    out[3] = t22 * t25;
    out[4] = t25 * t39 + t24 * t46;
    out[5] = t25 * t45 - t23 * t46;
    out[6] = t25 * t43 + t22 * t46;
    out[7] = t25 * t41 - t21 * t46;
}

void motorcade_corrected(const double pose[8], const double velocity[3], const double error[9],
        double out[8], double out_velocity[3])
{
    const double pose0 = pose[0], pose1 = pose[1], pose2 = pose[2], pose3 = pose[3];
    const double pose4 = pose[4], pose5 = pose[5], pose6 = pose[6], pose7 = pose[7];
    const double velocity0 = velocity[0], velocity1 = velocity[1], velocity2 = velocity[2];
    const double error0 = error[0], error1 = error[1], error2 = error[2], error3 = error[3];
    const double error4 = error[4], error5 = error[5], error6 = error[6], error7 = error[7];
    const double error8 = error[8];
    const double t0 = -0.5 * error2;
    const double t1 = -0.5 * error1;
    const double t2 = -0.5 * error0;
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const double t4 = sqrt(t3);
    const double t5 = floor(0.3183098861837907 * t4 + 0.5);
    const double t6 = 1.0 - 2.0 * (t5 - floor(0.5 * t5) * 2.0);
    const double t7 = t4 - t5 * 3.1415926218032837 - t5 * 3.1786509424591713e-08 - t5 *
        1.2246467202362698e-16;
    const double t8 = t7 - t5 * 7.891108333126411e-24;
    const double t9 = t8 * t8;
    const double t10 = t9 * (t9 * (4.608909074888812e-14 * t9 + -1.146289561457958e-11) +
        2.0876561604575935e-09);
    const double t11 = t9 * (t9 * (t10 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
        -0.0013888888888772708;
    const double t12 = t6 * (1.0 + t9 * (t9 * (t9 * t11 + 0.041666666666663875) +
        -0.4999999999999997));
    const _Bool t13 = (t5 < 0.5);
    const double t14 = t9 * (t9 * (t9 * 2.721539074015491e-15 + -7.643023238169083e-13) +
        1.6058940754212953e-10);
    const double t15 = t9 * (t9 * (t14 + -2.505210688815946e-08) + 2.755731921120387e-06) +
        -0.00019841269841208527;
    const double t16 = 1.0 + t9 * (t9 * (t9 * t15 + 0.008333333333333186) + -0.16666666666666666);
    const double t17 = (t13 ? t16 : t16 * (t6 * t8) / fmax(1.0, t4));
    const double t18 = t0 * t17;
    const double t19 = t1 * t17;
    const double t20 = t2 * t17;
    const double t21 = pose0 * t12 - pose3 * t18 - pose2 * t19 - pose1 * t20;
    const double t22 = pose0 * t18 + t12 * pose3 - t19 * pose1 + pose2 * t20;
    const double t23 = pose3 * t20 - pose0 * t19 - t12 * pose2 - t18 * pose1;
    const double t24 = pose0 * t20 - t18 * pose2 + t12 * pose1 + pose3 * t19;
    const double t25 = 1.5 - 0.5 * (t21 * t21 + t22 * t22 + t23 * t23 + t24 * t24);
    const double t26 = t21 * t25;
    const double t27 = t24 * t25;
    const double t28 = t23 * t25;
    const double t29 = t22 * t25;
    const double t30 = -0.5 * error3;
    const double t31 = t9 * (t9 * (t9 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
        9.635366495989451e-10);
    const double t32 = t9 * (t9 * (t31 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
        -0.0005952380952367574;
    const double t33 = (t13 ? -0.16666666666666666 + t9 * (t9 * t32 + 0.01666666666666651) : (t12 -
        t17) / (2.0 * fmax(1.0, t3)));
    const double t34 = -0.5 * error5;
    const double t35 = -0.5 * error4;
    const double t36 = 2.0 * (t2 * t30 + (t0 * t34 + t1 * t35));
    const double t37 = t33 * t36;
    const double t38 = t17 * t30 + t2 * t37;
    const double t39 = t17 * t35 + t1 * t37;
    const double t40 = t17 * t34 + t0 * t37;
    const double t41 = -0.5 * t17;
    const double t42 = t36 * t41;
    const double t43 = pose0 * t38 + pose3 * t39 - pose2 * t40 + t12 * pose4 + pose1 * t42 - t18 *
        pose5 + t19 * pose6;
    const double t44 = t43 - t20 * pose7;
    const double t45 = pose3 * t40 - pose0 * t42 + t20 * pose4 + pose1 * t38 + t18 * pose6 + t12 *
        pose7 + pose2 * t39;
    const double t46 = t45 + t19 * pose5;
    const double t47 = pose0 * t40 - t19 * pose4 + t20 * pose5 + t12 * pose6 + pose3 * t42 + pose2 *
        t38 - pose1 * t39;
    const double t48 = t47 - t18 * pose7;
    const double t49 = pose0 * t39 + pose2 * t42 + t18 * pose4 + pose1 * t40 + t12 * pose5 - t19 *
        pose7 - pose3 * t38;
    const double t50 = t49 - t20 * pose6;
    const double t51 = 0.5 * (2.0 * (t21 * t46 + t23 * t50 - t22 * t48 - t24 * t44));
    const double t52 = -0.5 * error6;
    const double t53 = -0.5 * error8;
    const double t54 = -0.5 * error7;
    const double t55 = 2.0 * (t2 * t52 + (t0 * t53 + t1 * t54));
    const double t56 = t33 * t55;
    const double t57 = t17 * t52 + t2 * t56;
    const double t58 = t17 * t54 + t1 * t56;
    const double t59 = t17 * t53 + t0 * t56;
    const double t60 = -0.5 * velocity0;
    const double t61 = -0.5 * velocity1;
    const double t62 = -0.5 * velocity2;
    const double t63 = pose0 * t60 - pose3 * t61 + pose2 * t62;
    const double t64 = t41 * t55;
    const double t65 = pose3 * t60 + pose0 * t61 - pose1 * t62;
    const double t66 = pose1 * t61 - pose2 * t60 + pose0 * t62;
    const double t67 = pose0 * t57 + pose3 * t58 - pose2 * t59 + t12 * t63 + pose1 * t64 - t18 * t65
        + t19 * t66;
    const double t68 = pose1 * t60 + pose3 * t62 + pose2 * t61;
    const double t69 = t67 - t20 * t68;
    const double t70 = pose3 * t59 - pose0 * t64 + t20 * t63 + pose1 * t57 + t18 * t66 + t12 * t68 +
        pose2 * t58;
    const double t71 = t70 + t19 * t65;
    const double t72 = pose0 * t59 - t19 * t63 + t20 * t65 + t12 * t66 + pose3 * t64 + pose2 * t57 -
        pose1 * t58;
    const double t73 = t72 - t18 * t68;
    const double t74 = pose0 * t58 + pose2 * t64 + t18 * t63 + pose1 * t59 + t12 * t65 - t19 * t68 -
        pose3 * t57;
    const double t75 = t74 - t20 * t66;
    const double t76 = 0.5 * (2.0 * (t21 * t71 + t23 * t75 - t22 * t73 - t24 * t69));
    const double t77 = t25 * t69 + t24 * t76;
    const double t78 = t25 * t75 - t23 * t76;
    const double t79 = t25 * t73 + t22 * t76;
    const double t80 = t25 * t71 - t21 * t76;
    out[0] = t26;
    out[1] = t27;
    out[2] = -t28;
    out[3] = t29;
    out[4] = t25 * t44 + t24 * t51;
    out[5] = t25 * t50 - t23 * t51;
    out[6] = t25 * t48 + t22 * t51;
    out[7] = t25 * t46 - t21 * t51;
    out_velocity[0] = -2.0 * (t26 * t77 + t29 * t78 + t28 * t79 + t27 * t80);
    out_velocity[1] = -2.0 * (t26 * t78 - t29 * t77 - t28 * t80 + t27 * t79);
    out_velocity[2] = -2.0 * (t26 * t79 - (t28 * t77 + t27 * t78) + t29 * t80);
}

void motorcade_start(const double measured[8], const double imu_T_camera[8], double pose[8],
        double effect[36])
{
    const double measured0 = measured[0], measured1 = measured[1], measured2 = measured[2],
        measured3 = measured[3];
    const double measured4 = measured[4], measured5 = measured[5], measured6 = measured[6],
        measured7 = measured[7];
    const double imu_T_camera0 = imu_T_camera[0], imu_T_camera1 = imu_T_camera[1], imu_T_camera2 =
        imu_T_camera[2], imu_T_camera3 = imu_T_camera[3];
    const double imu_T_camera4 = imu_T_camera[4], imu_T_camera5 = imu_T_camera[5], imu_T_camera6 =
        imu_T_camera[6], imu_T_camera7 = imu_T_camera[7];
    const double t0 = measured0 * imu_T_camera0 + measured3 * imu_T_camera3 + measured2 *
        imu_T_camera2 + measured1 * imu_T_camera1;
    const double t1 = imu_T_camera3 * measured2 - measured0 * imu_T_camera1 + imu_T_camera0 *
        measured1 - measured3 * imu_T_camera2;
    const double t2 = measured0 * imu_T_camera2 - measured3 * imu_T_camera1 - imu_T_camera0 *
        measured2 + imu_T_camera3 * measured1;
    const double t3 = imu_T_camera0 * measured3 - measured0 * imu_T_camera3 + imu_T_camera2 *
        measured1 - measured2 * imu_T_camera1;
    const double t4 = measured2 * imu_T_camera6 - (measured0 * imu_T_camera4 + measured3 *
        imu_T_camera5) + imu_T_camera0 * measured4;
    const double t5 = t4 - measured1 * imu_T_camera7 + imu_T_camera3 * measured5 - imu_T_camera2 *
        measured6;
    const double t6 = measured0 * imu_T_camera5 + measured2 * imu_T_camera7 + imu_T_camera3 *
        measured4 + measured1 * imu_T_camera6;
    const double t7 = imu_T_camera0 * measured5 - t6 + imu_T_camera2 * measured7 + measured3 *
        imu_T_camera4;
    const double t8 = imu_T_camera2 * measured4 - measured0 * imu_T_camera6 - imu_T_camera1 *
        measured5 + imu_T_camera0 * measured6;
    const double t9 = t8 - measured3 * imu_T_camera7 - measured2 * imu_T_camera4 + measured1 *
        imu_T_camera5;
    const double t10 = measured0 * imu_T_camera7 - measured3 * imu_T_camera6 - imu_T_camera1 *
        measured4 - measured1 * imu_T_camera4;
    const double t11 = t10 - imu_T_camera3 * measured6 + imu_T_camera0 * measured7 - measured2 *
        imu_T_camera5;
    const double t12 = imu_T_camera0 * -0.5;
    const double t13 = imu_T_camera0 * t12;
    const double t14 = imu_T_camera3 * -0.5;
    const double t15 = imu_T_camera3 * t14;
    const double t16 = imu_T_camera1 * -0.5;
    const double t17 = imu_T_camera1 * t16;
    const double t18 = imu_T_camera2 * -0.5;
    const double t19 = imu_T_camera2 * t18;
    const double t20 = imu_T_camera0 * t14;
    const double t21 = imu_T_camera1 * t18;
    const double t22 = imu_T_camera3 * t12;
    const double t23 = imu_T_camera2 * t16;
    const double t24 = imu_T_camera1 * t14;
    const double t25 = imu_T_camera3 * t16;
    const double t26 = imu_T_camera0 * t18;
    const double t27 = imu_T_camera2 * t12;
    const double t28 = imu_T_camera2 * t14;
    const double t29 = imu_T_camera1 * t12;
    const double t30 = imu_T_camera0 * t16;
    const double t31 = imu_T_camera3 * t18;
    const double t32 = imu_T_camera4 * -0.5;
    const double t33 = imu_T_camera1 * t32;
    const double t34 = imu_T_camera7 * -0.5;
    const double t35 = imu_T_camera0 * t34;
    const double t36 = imu_T_camera5 * t18;
    const double t37 = imu_T_camera4 * t16;
    const double t38 = imu_T_camera6 * t14;
    const double t39 = imu_T_camera7 * t12;
    const double t40 = imu_T_camera6 * -0.5;
    const double t41 = imu_T_camera3 * t40;
    const double t42 = imu_T_camera5 * -0.5;
    const double t43 = imu_T_camera2 * t42;
    const double t44 = imu_T_camera0 * t40;
    const double t45 = imu_T_camera4 * t18;
    const double t46 = imu_T_camera5 * t16;
    const double t47 = imu_T_camera6 * t12;
    const double t48 = imu_T_camera7 * t14;
    const double t49 = imu_T_camera3 * t34;
    const double t50 = imu_T_camera2 * t32;
    const double t51 = imu_T_camera1 * t42;
    const double t52 = imu_T_camera7 * t18;
    const double t53 = imu_T_camera0 * t42;
    const double t54 = imu_T_camera5 * t12;
    const double t55 = imu_T_camera4 * t14;
    const double t56 = imu_T_camera6 * t16;
    const double t57 = imu_T_camera3 * t32;
    const double t58 = imu_T_camera2 * t34;
    const double t59 = imu_T_camera1 * t40;
    const double t60 = t13 - t15;
    const double t61 = t20 + t22;
    const double t62 = imu_T_camera5 * t14;
    const double t63 = imu_T_camera7 * t16;
    const double t64 = imu_T_camera3 * t42;
    const double t65 = imu_T_camera6 * t18;
    const double t66 = imu_T_camera0 * t32;
    const double t67 = imu_T_camera2 * t40;
    const double t68 = imu_T_camera4 * t12;
    const double t69 = imu_T_camera1 * t34;
    pose[0] = t0;
    pose[1] = t1;
    pose[2] = -t2;
    pose[3] = t3;
    pose[4] = t5 + imu_T_camera1 * measured7;
    pose[5] = t7 + imu_T_camera1 * measured6;
    pose[6] = t9 + imu_T_camera3 * measured7;
    pose[7] = t11 - imu_T_camera2 * measured5;
    effect[0] = -2.0 * (t13 - (t15 - t17) - t19);
    effect[1] = -2.0 * (t20 + (t21 + t22) + t23);
    effect[2] = -2.0 * (t24 + t25 - t26 - t27);
    effect[3] = 0.0;
    effect[4] = 0.0;
    effect[5] = 0.0;
    effect[6] = -(-2.0 * (t22 + (t20 - (t21 + t23))));
    effect[7] = -(-2.0 * (t15 + (t17 - t19 - t13)));
    effect[8] = -2.0 * (t28 + t29 + t30 + t31);
    effect[9] = 0.0;
    effect[10] = 0.0;
    effect[11] = 0.0;
    effect[12] = -2.0 * (t24 + (t27 + (t25 + t26)));
    effect[13] = -2.0 * (t28 + (t31 - t30) - t29);
    effect[14] = -2.0 * (t13 + t15 - t19 - t17);
    effect[15] = 0.0;
    effect[16] = 0.0;
    effect[17] = 0.0;
    effect[18] = -2.0 * (t33 - (t35 + (t36 - t37 + t38) + t39 + t41 + t43));
    effect[19] = -2.0 * (t44 + (t45 + t46 + t47) - t48 - t49 + t50 + t51);
    effect[20] = -2.0 * (t52 - (t53 + (t54 - t55 - t56)) + t57 + t58 + t59);
    effect[21] = -2.0 * (t17 + (t60 - t19));
    effect[22] = -2.0 * (t21 + (t23 + t61));
    effect[23] = -2.0 * (t24 + (t25 - t26 - t27));
    effect[24] = -2.0 * (t51 + (t45 + (t50 + (t49 + (t46 + t48) - t47 - t44))));
    effect[25] = -2.0 * (t43 + (t36 - t39 - t41 - t38 - t35) - t37 - t33);
    effect[26] = -2.0 * (t62 - t63 + t64 + t65 + t66 + t67 + t68 - t69);
    effect[27] = -2.0 * (t21 + (t23 - t61));
    effect[28] = -2.0 * (t19 + t60 - t17);
    effect[29] = -2.0 * (t29 + (t28 + (t30 + t31)));
    effect[30] = -2.0 * (t57 + (t54 + (t55 + (t53 + (t59 + (t56 - t58)) - t52))));
    effect[31] = -2.0 * (t64 + (t62 + (t63 + (t69 + (t65 + t67) - t66) - t68)));
    effect[32] = -2.0 * (t41 + (t38 - t43 - t33 - t35 - t39 - t37 - t36));
    effect[33] = -2.0 * (t25 + (t26 + (t24 + t27)));
    effect[34] = -2.0 * (t31 + (t28 - t29 - t30));
    effect[35] = -2.0 * (t15 + (t13 - (t17 + t19)));
}

void motorcade_pose_residual(const double pose[8], const double imu_T_camera[8],
        const double measured[8], double residual[6])
{
    const double pose0 = pose[0], pose1 = pose[1], pose2 = pose[2], pose3 = pose[3];
    const double pose4 = pose[4], pose5 = pose[5], pose6 = pose[6], pose7 = pose[7];
    const double imu_T_camera0 = imu_T_camera[0], imu_T_camera1 = imu_T_camera[1], imu_T_camera2 =
        imu_T_camera[2], imu_T_camera3 = imu_T_camera[3];
    const double imu_T_camera4 = imu_T_camera[4], imu_T_camera5 = imu_T_camera[5], imu_T_camera6 =
        imu_T_camera[6], imu_T_camera7 = imu_T_camera[7];
    const double measured0 = measured[0], measured1 = measured[1], measured2 = measured[2],
        measured3 = measured[3];
    const double measured4 = measured[4], measured5 = measured[5], measured6 = measured[6],
        measured7 = measured[7];
    const double t0 = pose0 * imu_T_camera0 - pose3 * imu_T_camera3 - pose2 * imu_T_camera2 - pose1
        * imu_T_camera1;
    const double t1 = pose0 * imu_T_camera3 + imu_T_camera0 * pose3 - imu_T_camera2 * pose1 + pose2
        * imu_T_camera1;
    const double t2 = pose3 * imu_T_camera1 - pose0 * imu_T_camera2 - imu_T_camera0 * pose2 -
        imu_T_camera3 * pose1;
    const double t3 = pose0 * imu_T_camera1 - imu_T_camera3 * pose2 + imu_T_camera0 * pose1 + pose3
        * imu_T_camera2;
    const double t4 = t0 * measured0 + t1 * measured3 - t2 * measured2 + t3 * measured1;
    const double t5 = ((t4 < 0.0) ? -1.0 : 1.0);
    const double t6 = 1.0 - t4 * t5;
    const double t7 = t6 * (t6 * (8.121007252839173e-05 * t6 + -0.0007281273643381516) +
        0.0030973904722135883);
    const double t8 = t6 * (t6 * (t7 + -0.00821750089765482) + 0.015180613767041282) +
        -0.020647830091351717;
    const double t9 = t6 * (t6 * (t6 * t8 + 0.02139495485791656) + -0.017185237019630522) +
        0.010890803896660979;
    const double t10 = t6 * (t6 * (t6 * t9 + -0.0053548548506220615) + 0.0022588396994592773) +
        -0.00039674989569360273;
    const double t11 = t6 * (t6 * (t6 * t10 + 0.0007138968794314861) + 0.0011403814338107978) +
        0.002490569286343547;
    const double t12 = t6 * (t6 * (t6 * t11 + 0.005327576046333906) + 0.011544042766655997) +
        0.02539682388201735;
    const double t13 = t6 * (t6 * (t6 * t12 + 0.0571428571878089) + 0.1333333333326277) +
        0.3333333333333377;
    const double t14 = 1.0 + t6 * t13;
    const double t15 = t5 * (t0 * measured1 - measured3 * t2 - measured0 * t3 - t1 * measured2);
    const double t16 = t5 * (measured3 * t3 - (t0 * measured2 + t1 * measured1 + measured0 * t2));
    const double t17 = t5 * (t0 * measured3 - measured0 * t1 + measured2 * t3 + t2 * measured1);
    const double t18 = pose0 * imu_T_camera4 + pose3 * imu_T_camera5 - pose2 * imu_T_camera6 +
        imu_T_camera0 * pose4;
    const double t19 = t18 - pose1 * imu_T_camera7 - imu_T_camera3 * pose5 + imu_T_camera2 * pose6 -
        imu_T_camera1 * pose7;
    const double t20 = pose0 * imu_T_camera5 - pose2 * imu_T_camera7 + imu_T_camera3 * pose4 + pose1
        * imu_T_camera6;
    const double t21 = t20 + imu_T_camera0 * pose5 - imu_T_camera2 * pose7 - pose3 * imu_T_camera4 -
        imu_T_camera1 * pose6;
    const double t22 = t0 * measured4 - t1 * measured5 - t2 * measured6 - measured0 * t19 + t3 *
        measured7 + measured3 * t21;
    const double t23 = pose0 * imu_T_camera6 - imu_T_camera2 * pose4 + imu_T_camera1 * pose5 +
        imu_T_camera0 * pose6;
    const double t24 = t23 - pose3 * imu_T_camera7 + pose2 * imu_T_camera4 - pose1 * imu_T_camera5 -
        imu_T_camera3 * pose7;
    const double t25 = pose0 * imu_T_camera7 + pose3 * imu_T_camera6 + imu_T_camera1 * pose4 + pose1
        * imu_T_camera4;
    const double t26 = t25 + imu_T_camera3 * pose6 + imu_T_camera0 * pose7 + pose2 * imu_T_camera5 +
        imu_T_camera2 * pose5;
    const double t27 = t6 * (t6 * (t6 * 0.0006075023168817953 + -0.006093589939124222) +
        0.029004300694938867);
    const double t28 = t6 * (t6 * (t6 * (t27 + -0.08654292963332932) + 0.18095358835013511) +
        -0.2810123057357625);
    const double t29 = t6 * (t6 * (t6 * (t28 + 0.33558766073322116) + -0.3148060210252562) +
        0.23526461066915133);
    const double t30 = t6 * (t6 * (t29 + -0.1409288051389536) + 0.06829876555117628) +
        -0.026100111052203438;
    const double t31 = t6 * (t6 * (t6 * t30 + 0.008987626539449197) + -0.0006646325108237732) +
        0.003041430518339829;
    const double t32 = t6 * (t6 * (t6 * t31 + 0.004927059512671586) + 0.009367637463823044) +
        0.017404214982763427;
    const double t33 = t6 * (t6 * (t6 * t32 + 0.03196806840632643) + 0.05772005624453496) +
        0.10158730162394855;
    const double t34 = t6 * (t6 * (t6 * t33 + 0.17142857142808898) + 0.2666666666666692) +
        0.3333333333333333;
    const double t35 = t0 * measured7 - t1 * measured6 - measured1 * t19 - t3 * measured4 -
        measured3 * t24 + measured0 * t26;
    const double t36 = t34 * (t5 * (t35 + t2 * measured5 - measured2 * t21));
    const double t37 = t0 * measured5 - t2 * measured7 - measured3 * t19 - t3 * measured6 -
        measured0 * t21 - measured2 * t26;
    const double t38 = t0 * measured6 + measured2 * t19 - measured1 * t21 - measured0 * t24 + t1 *
        measured7;
    const double t39 = -2.0 * (t14 * (t5 * (t38 + t2 * measured4 + t3 * measured5 - measured3 *
        t26)) + t17 * t36);
    residual[0] = -2.0 * (t14 * t15);
    residual[1] = -(-2.0 * (t14 * t16));
    residual[2] = -2.0 * (t14 * t17);
    residual[3] = -2.0 * (t14 * (t5 * (t22 - measured2 * t24 - measured1 * t26)) + t15 * t36);
    residual[4] = -2.0 * (t14 * (t5 * (t37 + t1 * measured4 + measured1 * t24)) - t16 * t36);
    residual[5] = t39;
}

void motorcade_pose_effect(const double imu_T_camera[8], double effect[36])
{
    const double imu_T_camera0 = imu_T_camera[0], imu_T_camera1 = imu_T_camera[1], imu_T_camera2 =
        imu_T_camera[2], imu_T_camera3 = imu_T_camera[3];
    const double imu_T_camera4 = imu_T_camera[4], imu_T_camera5 = imu_T_camera[5], imu_T_camera6 =
        imu_T_camera[6], imu_T_camera7 = imu_T_camera[7];
    const double t0 = imu_T_camera1 * -0.5;
    const double t1 = imu_T_camera1 * t0;
    const double t2 = -0.5 * imu_T_camera3;
    const double t3 = imu_T_camera3 * t2;
    const double t4 = -0.5 * imu_T_camera0;
    const double t5 = imu_T_camera0 * t4;
    const double t6 = -0.5 * imu_T_camera2;
    const double t7 = imu_T_camera2 * t6;
    const double t8 = imu_T_camera1 * t6;
    const double t9 = imu_T_camera3 * t4;
    const double t10 = t2 * imu_T_camera0;
    const double t11 = t0 * imu_T_camera2;
    const double t12 = imu_T_camera1 * t2;
    const double t13 = t0 * imu_T_camera3;
    const double t14 = imu_T_camera0 * t6;
    const double t15 = t4 * imu_T_camera2;
    const double t16 = imu_T_camera1 * t4;
    const double t17 = t2 * imu_T_camera2;
    const double t18 = t0 * imu_T_camera0;
    const double t19 = imu_T_camera3 * t6;
    const double t20 = t0 * imu_T_camera4;
    const double t21 = t6 * imu_T_camera5;
    const double t22 = t2 * imu_T_camera6;
    const double t23 = -0.5 * imu_T_camera7;
    const double t24 = imu_T_camera0 * t23;
    const double t25 = t4 * imu_T_camera7;
    const double t26 = -0.5 * imu_T_camera6;
    const double t27 = imu_T_camera3 * t26;
    const double t28 = -0.5 * imu_T_camera5;
    const double t29 = imu_T_camera2 * t28;
    const double t30 = -0.5 * imu_T_camera4;
    const double t31 = imu_T_camera1 * t30;
    const double t32 = t6 * imu_T_camera4;
    const double t33 = t0 * imu_T_camera5;
    const double t34 = t4 * imu_T_camera6;
    const double t35 = imu_T_camera0 * t26;
    const double t36 = t2 * imu_T_camera7;
    const double t37 = imu_T_camera3 * t23;
    const double t38 = imu_T_camera2 * t30;
    const double t39 = imu_T_camera1 * t28;
    const double t40 = t2 * imu_T_camera4;
    const double t41 = t4 * imu_T_camera5;
    const double t42 = t0 * imu_T_camera6;
    const double t43 = imu_T_camera0 * t28;
    const double t44 = t6 * imu_T_camera7;
    const double t45 = imu_T_camera3 * t30;
    const double t46 = imu_T_camera2 * t23;
    const double t47 = imu_T_camera1 * t26;
    const double t48 = t5 - t3;
    const double t49 = t9 + t10;
    const double t50 = t2 * imu_T_camera5;
    const double t51 = t0 * imu_T_camera7;
    const double t52 = imu_T_camera3 * t28;
    const double t53 = t6 * imu_T_camera6;
    const double t54 = imu_T_camera0 * t30;
    const double t55 = imu_T_camera2 * t26;
    const double t56 = t4 * imu_T_camera4;
    const double t57 = imu_T_camera1 * t23;
    effect[0] = -2.0 * (t1 - t3 + t5 - t7);
    effect[1] = -2.0 * (t8 - t9 - t10 + t11);
    effect[2] = -2.0 * (t12 + t13 + t14 + t15);
    effect[3] = 0.0;
    effect[4] = 0.0;
    effect[5] = 0.0;
    effect[6] = -2.0 * (t9 + (t10 + (t8 + t11)));
    effect[7] = -(-2.0 * (t3 + (t1 - t7 - t5)));
    effect[8] = -(-2.0 * (t16 - t17 + t18 - t19));
    effect[9] = 0.0;
    effect[10] = 0.0;
    effect[11] = 0.0;
    effect[12] = -2.0 * (t12 + (t13 - t14 - t15));
    effect[13] = -2.0 * (t16 + (t17 + (t18 + t19)));
    effect[14] = -2.0 * (t3 + t5 - t7 - t1);
    effect[15] = 0.0;
    effect[16] = 0.0;
    effect[17] = 0.0;
    effect[18] = -2.0 * (t20 - t21 - t22 - t24 - t25 - t27 - t29 + t31);
    effect[19] = -2.0 * (t32 + t33 - t34 - t35 + t36 + t37 + t38 + t39);
    effect[20] = -2.0 * (t40 + t41 + t42 + t43 - t44 + t45 - t46 + t47);
    effect[21] = -2.0 * (t1 + (t48 - t7));
    effect[22] = -2.0 * (t8 + (t11 - t49));
    effect[23] = -2.0 * (t12 + (t15 + (t13 + t14)));
    effect[24] = -2.0 * (t39 + (t32 + (t38 + (t35 + (t34 + (t33 - t36 - t37))))));
    effect[25] = -2.0 * (t29 + (t21 - t25 - t27 - t22 - t24) - t20 - t31);
    effect[26] = -2.0 * (t50 + t51 + t52 + t53 - t54 + t55 - t56 + t57);
    effect[27] = -2.0 * (t8 + (t11 + t49));
    effect[28] = -2.0 * (t7 + t48 - t1);
    effect[29] = -2.0 * (t17 + (t19 - t18) - t16);
    effect[30] = -2.0 * (t45 + (t40 + (t44 + (t47 + (t42 + t46) - t43)) - t41));
    effect[31] = -2.0 * (t52 + (t50 + (t56 + (t54 + (t53 + t55 - t57) - t51))));
    effect[32] = -2.0 * (t27 + (t22 - t29 - t31 - t24 - t25 - t20 - t21));
    effect[33] = -2.0 * (t13 + (t12 - t15 - t14));
    effect[34] = -2.0 * (t19 + (t18 + (t16 + t17)));
    effect[35] = -2.0 * (t3 + (t5 - (t1 + t7)));
}

void motorcade_point(const double pose[8], const double arm[3], double at[3], double effect[18])
{
    const double pose0 = pose[0], pose1 = pose[1], pose2 = pose[2], pose3 = pose[3];
    const double pose4 = pose[4], pose5 = pose[5], pose6 = pose[6], pose7 = pose[7];
    const double arm0 = arm[0], arm1 = arm[1], arm2 = arm[2];
    const double t0 = pose0 * arm0 + pose3 * arm1 - pose2 * arm2;
    const double t1 = pose0 * arm1 + arm2 * pose1 - arm0 * pose3;
    const double t2 = pose0 * arm2 + arm0 * pose2 - arm1 * pose1;
    const double t3 = pose3 * arm2 + arm0 * pose1 + arm1 * pose2;
    const double t4 = pose0 * t0 + pose3 * t1 - pose2 * t2 + pose1 * t3 + -2.0 * (pose0 * pose4 +
        pose3 * pose5 - pose2 * pose6 + pose1 * pose7);
    const double t5 = pose0 * t1 - pose3 * t0 + pose2 * t3 + pose1 * t2 + -2.0 * (pose0 * pose5 -
        pose3 * pose4 + pose2 * pose7 + pose1 * pose6);
    const double t6 = pose2 * t0 - pose1 * t1 + pose0 * t2 + pose3 * t3 + -2.0 * (pose2 * pose4 -
        pose1 * pose5 + pose0 * pose6 + pose3 * pose7);
    const double t7 = pose2 * -0.5;
    const double t8 = arm1 * t7;
    const double t9 = pose1 * -0.5;
    const double t10 = arm0 * t9;
    const double t11 = pose3 * -0.5;
    const double t12 = arm2 * t11;
    const double t13 = t8 - t10 + t12;
    const double t14 = t0 * t9;
    const double t15 = pose0 * -0.5;
    const double t16 = arm2 * t15;
    const double t17 = arm1 * t9;
    const double t18 = arm0 * t7;
    const double t19 = t16 - t17 - t18;
    const double t20 = t1 * t7;
    const double t21 = t2 * t11;
    const double t22 = arm2 * t9;
    const double t23 = arm0 * t11;
    const double t24 = arm1 * t15;
    const double t25 = t22 + t23 + t24;
    const double t26 = arm2 * t7;
    const double t27 = arm0 * t15;
    const double t28 = arm1 * t11;
    const double t29 = t26 + t27 - t28;
    const double t30 = t3 * t15;
    const double t31 = pose5 * t7;
    const double t32 = pose6 * -0.5;
    const double t33 = pose3 * t32;
    const double t34 = pose7 * -0.5;
    const double t35 = pose0 * t34;
    const double t36 = pose4 * t9;
    const double t37 = pose6 * t11;
    const double t38 = pose5 * -0.5;
    const double t39 = pose2 * t38;
    const double t40 = pose4 * -0.5;
    const double t41 = pose1 * t40;
    const double t42 = pose7 * t15;
    const double t43 = pose0 * t13 - t14 + (pose3 * t19 + t20) + (t21 + pose2 * t25) + (pose1 * t29
        + t30) + -2.0 * (t31 - t33 - (t35 + t36) + (t37 - t39) + (t41 + t42));
    const double t44 = t10 + (t12 - t8);
    const double t45 = t1 * t9;
    const double t46 = t16 + (t17 + t18);
    const double t47 = t0 * t7;
    const double t48 = t27 - t26 - t28;
    const double t49 = t2 * t15;
    const double t50 = t24 + (t23 - t22);
    const double t51 = t3 * t11;
    const double t52 = pose0 * t32;
    const double t53 = pose4 * t7;
    const double t54 = pose3 * t34;
    const double t55 = pose5 * t9;
    const double t56 = pose6 * t15;
    const double t57 = pose2 * t40;
    const double t58 = pose1 * t38;
    const double t59 = pose7 * t11;
    const double t60 = pose3 * t44 - t45 - (pose0 * t46 + t47) - (pose2 * t48 + t49) + (pose1 * t50
        + t51) + -2.0 * (t52 - t53 - (t54 + t55) - (t56 - t57) + (t58 + t59));
    const double t61 = t24 - t23 - t22;
    const double t62 = t0 * t11;
    const double t63 = t1 * t15;
    const double t64 = t27 + (t26 + t28);
    const double t65 = t8 + (t10 - t12);
    const double t66 = t2 * t9;
    const double t67 = t17 + (t16 - t18);
    const double t68 = t3 * t7;
    const double t69 = pose3 * t40;
    const double t70 = pose5 * t15;
    const double t71 = pose0 * t38;
    const double t72 = pose4 * t11;
    const double t73 = pose6 * t9;
    const double t74 = pose2 * t34;
    const double t75 = pose1 * t32;
    const double t76 = pose7 * t7;
    const double t77 = pose0 * t61 - t62 + (t63 - pose3 * t64) - (pose2 * t65 + t66) + (pose1 * t67
        - t68) + -2.0 * (t69 + t70 - (t71 + t72) - (t73 - t74) + (t75 - t76));
    const double t78 = pose0 * t15;
    const double t79 = pose3 * t11;
    const double t80 = t78 - t79;
    const double t81 = pose2 * t7;
    const double t82 = pose1 * t9;
    const double t83 = pose0 * t11 + pose3 * t15;
    const double t84 = pose2 * t9;
    const double t85 = pose1 * t7;
    const double t86 = pose3 * t9;
    const double t87 = pose0 * t7;
    const double t88 = pose2 * t15;
    const double t89 = pose1 * t11;
    const double t90 = pose0 * t19 - t45 - (t47 + pose3 * t13) - (t51 - pose2 * t29) + (t49 - pose1
        * t25) + -2.0 * (t56 + t58 - (t52 + t55 + (t53 - t54) + (t59 - t57)));
    const double t91 = pose0 * t44 - t20 + (t14 + pose3 * t46) + (t30 + pose2 * t50) + (t21 + pose1
        * t48) + -2.0 * (t37 - t41 - (t31 + t35 + (t33 - t36) - (t39 + t42)));
    const double t92 = t2 * t7;
    const double t93 = t1 * t11;
    const double t94 = t0 * t15;
    const double t95 = t3 * t9;
    const double t96 = pose0 * t40;
    const double t97 = pose5 * t11;
    const double t98 = pose4 * t15;
    const double t99 = pose3 * t38;
    const double t100 = pose2 * t32;
    const double t101 = pose7 * t9;
    const double t102 = pose1 * t34;
    const double t103 = pose6 * t7;
    const double t104 = pose1 * t65 - t92 - (pose0 * t64 + t93 + (pose3 * t61 + t94) - (pose2 * t67
        + t95)) + -2.0 * (t96 - t97 - (t98 - t99) + (t100 + t101) - (t102 + t103));
    const double t105 = pose0 * t9;
    const double t106 = pose3 * t7;
    const double t107 = pose2 * t11;
    const double t108 = pose1 * t15;
    const double t109 = t68 + pose3 * t29 - (t66 + pose0 * t25 + (t62 - pose2 * t13 + (t63 + pose1 *
        t19))) + -2.0 * (t71 - t73 - (t72 + t74 + (t70 - t75)) + (t69 + t76));
    const double t110 = pose0 * t48 - t92 - (t93 + pose1 * t44 - (t94 - pose2 * t46)) + (pose3 * t50
        - t95) + -2.0 * (t99 - t101 - (t96 + t103 + (t97 - t102 - (t98 + t100))));
    const double t111 = pose0 * t65 - t21 + (t14 + pose2 * t61 + (t20 + pose1 * t64)) + (t30 + pose3
        * t67) + -2.0 * (t33 + t42 - (t35 + t37 + (t41 - t31 - (t36 - t39))));
    at[0] = t4;
    at[1] = t5;
    at[2] = t6;
    effect[0] = t43;
    effect[1] = t60;
    effect[2] = t77;
    effect[3] = -2.0 * (t80 - t81 + t82);
    effect[4] = -2.0 * (t83 + t84 + t85);
    effect[5] = -2.0 * (t86 - t87 - t88 + t89);
    effect[6] = t90;
    effect[7] = t91;
    effect[8] = t104;
    effect[9] = -2.0 * (t85 - (t83 - t84));
    effect[10] = -2.0 * (t80 + t81 - t82);
    effect[11] = -2.0 * (t105 + t106 + t107 + t108);
    effect[12] = t109;
    effect[13] = t110;
    effect[14] = t111;
    effect[15] = -2.0 * (t86 + (t87 + (t88 + t89)));
    effect[16] = -2.0 * (t106 - (t105 + (t108 - t107)));
    effect[17] = -2.0 * (t79 + (t78 - (t81 + t82)));
}

void motorcade_velocity_effect(const double pose[8], double effect[9])
{
    const double pose0 = pose[0], pose1 = pose[1], pose2 = pose[2], pose3 = pose[3];
    const double t0 = pose0 * pose0;
    const double t1 = pose3 * pose3;
    const double t2 = t0 - t1;
    const double t3 = pose2 * pose2;
    const double t4 = pose1 * pose1;
    const double t5 = pose0 * pose3 * 2.0;
    const double t6 = 2.0 * (pose2 * pose1);
    const double t7 = pose3 * pose1;
    const double t8 = pose0 * pose2;
    const double t9 = pose0 * pose1;
    const double t10 = pose3 * pose2;
    effect[0] = t2 - t3 + t4;
    effect[1] = t5 + t6;
    effect[2] = 2.0 * (t7 - t8);
    effect[3] = t6 - t5;
    effect[4] = t2 + t3 - t4;
    effect[5] = 2.0 * (t9 + t10);
    effect[6] = 2.0 * (t7 + t8);
    effect[7] = 2.0 * (t10 - t9);
    effect[8] = t1 + (t0 - (t3 + t4));
}

void motorcade_corner(const double pose[8], const double imu_T_camera[8], const double point[3],
        double seen[2], double depth[1], double pose_effect[12], double extrinsics_effect[12])
{
    const double pose0 = pose[0], pose1 = pose[1], pose2 = pose[2], pose3 = pose[3];
    const double pose4 = pose[4], pose5 = pose[5], pose6 = pose[6], pose7 = pose[7];
    const double imu_T_camera0 = imu_T_camera[0], imu_T_camera1 = imu_T_camera[1], imu_T_camera2 =
        imu_T_camera[2], imu_T_camera3 = imu_T_camera[3];
    const double imu_T_camera4 = imu_T_camera[4], imu_T_camera5 = imu_T_camera[5], imu_T_camera6 =
        imu_T_camera[6], imu_T_camera7 = imu_T_camera[7];
    const double point0 = point[0], point1 = point[1], point2 = point[2];
    const double t0 = pose0 * imu_T_camera0 - pose3 * imu_T_camera3 - pose2 * imu_T_camera2 - pose1
        * imu_T_camera1;
    const double t1 = pose0 * imu_T_camera3 + imu_T_camera0 * pose3 - imu_T_camera2 * pose1 + pose2
        * imu_T_camera1;
    const double t2 = pose3 * imu_T_camera1 - pose0 * imu_T_camera2 - imu_T_camera0 * pose2 -
        imu_T_camera3 * pose1;
    const double t3 = t0 * point0 - t1 * point1 - t2 * point2;
    const double t4 = pose0 * imu_T_camera1 - imu_T_camera3 * pose2 + imu_T_camera0 * pose1 + pose3
        * imu_T_camera2;
    const double t5 = t0 * point1 - point2 * t4 + point0 * t1;
    const double t6 = t0 * point2 + point0 * t2 + point1 * t4;
    const double t7 = point1 * t2 - (t1 * point2 + point0 * t4);
    const double t8 = pose0 * imu_T_camera5 - pose2 * imu_T_camera7 + imu_T_camera3 * pose4 + pose1
        * imu_T_camera6;
    const double t9 = t8 + imu_T_camera0 * pose5 - imu_T_camera2 * pose7 - pose3 * imu_T_camera4 -
        imu_T_camera1 * pose6;
    const double t10 = pose0 * imu_T_camera4 + pose3 * imu_T_camera5 - pose2 * imu_T_camera6 +
        imu_T_camera0 * pose4;
    const double t11 = t10 - pose1 * imu_T_camera7 - imu_T_camera3 * pose5 + imu_T_camera2 * pose6 -
        imu_T_camera1 * pose7;
    const double t12 = pose0 * imu_T_camera6 - imu_T_camera2 * pose4 + imu_T_camera1 * pose5 +
        imu_T_camera0 * pose6;
    const double t13 = t12 - pose3 * imu_T_camera7 + pose2 * imu_T_camera4 - pose1 * imu_T_camera5 -
        imu_T_camera3 * pose7;
    const double t14 = pose0 * imu_T_camera7 + pose3 * imu_T_camera6 + imu_T_camera1 * pose4 + pose1
        * imu_T_camera4;
    const double t15 = t14 + imu_T_camera3 * pose6 + imu_T_camera0 * pose7 + pose2 * imu_T_camera5 +
        imu_T_camera2 * pose5;
    const double t16 = t0 * t3 - t1 * t5 - t2 * t6 - t4 * t7 + -2.0 * (t1 * t9 - t0 * t11 + t2 * t13
        - t4 * t15);
    const double t17 = t2 * t3 + t4 * t5 + t0 * t6 - t1 * t7 - -2.0 * (t2 * t11 + t4 * t9 + t0 * t13
        + t1 * t15);
    const double t18 = 1.0 / t17;
    const double t19 = t16 * t18;
    const double t20 = t1 * t3 + t0 * t5 + t2 * t7 - t4 * t6 + -2.0 * (t2 * t15 - (t1 * t11 + t0 *
        t9) + t4 * t13);
    const double t21 = t18 * t20;
    const double t22 = t18 * t19;
    const double t23 = -2.0 * t22;
    const double t24 = -2.0 * t18;
    const double t25 = t4 * t24;
    const double t26 = t1 * t23 - t25;
    const double t27 = t2 * t24;
    const double t28 = t0 * t23 + t27;
    const double t29 = t0 * t24;
    const double t30 = t2 * t23 - t29;
    const double t31 = t1 * t24;
    const double t32 = t4 * t23 + t31;
    const double t33 = imu_T_camera3 * t26 + imu_T_camera0 * t28 + imu_T_camera2 * t30 -
        imu_T_camera1 * t32;
    const double t34 = imu_T_camera0 * t26 - imu_T_camera3 * t28 - imu_T_camera1 * t30 -
        imu_T_camera2 * t32;
    const double t35 = imu_T_camera2 * t26 + imu_T_camera1 * t28 - imu_T_camera3 * t30 +
        imu_T_camera0 * t32;
    const double t36 = imu_T_camera1 * t26 - imu_T_camera2 * t28 + imu_T_camera0 * t30 +
        imu_T_camera3 * t32;
    const double t37 = imu_T_camera4 * t26 - imu_T_camera5 * t28 - imu_T_camera7 * t30 +
        imu_T_camera6 * t32;
    const double t38 = t15 * t24;
    const double t39 = t7 * t18;
    const double t40 = t4 * t18;
    const double t41 = t1 * t22 - t40;
    const double t42 = t2 * t18;
    const double t43 = t0 * t22 + t42;
    const double t44 = t1 * t18;
    const double t45 = t4 * t22 + t44;
    const double t46 = t9 * t23 - t5 * t22 - t38 - t39 - point0 * t41 - point1 * t43 + point2 * t45;
    const double t47 = t13 * t24;
    const double t48 = t6 * t18;
    const double t49 = t0 * t18;
    const double t50 = t49 - t2 * t22;
    const double t51 = t11 * t23 - t3 * t22 + t47 + point1 * t41 - t48 - point0 * t43 - point2 *
        t50;
    const double t52 = t9 * t24;
    const double t53 = t5 * t18;
    const double t54 = t15 * t23 + t7 * t22 + t52 - point2 * t41 - t53 - point0 * t45 - point1 *
        t50;
    const double t55 = t11 * t24;
    const double t56 = t3 * t18;
    const double t57 = t13 * t23 - t6 * t22 - t55 - point2 * t43 - point1 * t45 + t56 + point0 *
        t50;
    const double t58 = t37 + imu_T_camera0 * t46 - imu_T_camera3 * t51 - imu_T_camera2 * t54 -
        imu_T_camera1 * t57;
    const double t59 = imu_T_camera6 * t30 - (imu_T_camera5 * t26 + imu_T_camera4 * t28) +
        imu_T_camera7 * t32;
    const double t60 = t59 + imu_T_camera3 * t46 + imu_T_camera0 * t51 - imu_T_camera1 * t54 +
        imu_T_camera2 * t57;
    const double t61 = imu_T_camera6 * t26 - imu_T_camera7 * t28 + imu_T_camera5 * t30 -
        imu_T_camera4 * t32;
    const double t62 = t61 + imu_T_camera2 * t46 + imu_T_camera1 * t51 + imu_T_camera0 * t54 -
        imu_T_camera3 * t57;
    const double t63 = pose5 * t33 + pose4 * t34 - pose6 * t35 - pose7 * t36 + pose0 * t58 + pose3 *
        t60 + pose2 * t62;
    const double t64 = imu_T_camera7 * t26 + imu_T_camera6 * t28 + imu_T_camera4 * t30 +
        imu_T_camera5 * t32;
    const double t65 = t64 + imu_T_camera1 * t46 - imu_T_camera2 * t51 + imu_T_camera3 * t54 +
        imu_T_camera0 * t57;
    const double t66 = pose5 * t34 - pose4 * t33 - pose7 * t35 + pose6 * t36 + pose3 * t58 - pose0 *
        t60 - pose1 * t62;
    const double t67 = pose6 * t34 - pose7 * t33 + pose4 * t35 - pose5 * t36 - pose2 * t58 - pose1 *
        t60 + pose0 * t62;
    const double t68 = t18 * t21;
    const double t69 = -2.0 * t68;
    const double t70 = t27 + t1 * t69;
    const double t71 = t25 + t0 * t69;
    const double t72 = t2 * t69 - t31;
    const double t73 = t4 * t69 - t29;
    const double t74 = imu_T_camera3 * t70 + imu_T_camera0 * t71 + imu_T_camera2 * t72 -
        imu_T_camera1 * t73;
    const double t75 = imu_T_camera0 * t70 - imu_T_camera3 * t71 - imu_T_camera1 * t72 -
        imu_T_camera2 * t73;
    const double t76 = imu_T_camera2 * t70 + imu_T_camera1 * t71 - imu_T_camera3 * t72 +
        imu_T_camera0 * t73;
    const double t77 = imu_T_camera1 * t70 - imu_T_camera2 * t71 + imu_T_camera0 * t72 +
        imu_T_camera3 * t73;
    const double t78 = imu_T_camera4 * t70 - imu_T_camera5 * t71 - imu_T_camera7 * t72 +
        imu_T_camera6 * t73;
    const double t79 = t42 + t1 * t68;
    const double t80 = t40 + t0 * t68;
    const double t81 = t49 - t4 * t68;
    const double t82 = t47 - t48 + t9 * t69 - t5 * t68 - point0 * t79 - point1 * t80 - point2 * t81;
    const double t83 = t44 - t2 * t68;
    const double t84 = t38 + t39 + t11 * t69 - t3 * t68 + point1 * t79 - point0 * t80 - point2 *
        t83;
    const double t85 = t56 - t55 + t15 * t69 + t7 * t68 - point2 * t79 + point0 * t81 - point1 *
        t83;
    const double t86 = t53 - t52 + t13 * t69 - t6 * t68 - point2 * t80 + point1 * t81 + point0 *
        t83;
    const double t87 = t78 + imu_T_camera0 * t82 - imu_T_camera3 * t84 - imu_T_camera2 * t85 -
        imu_T_camera1 * t86;
    const double t88 = imu_T_camera6 * t72 - (imu_T_camera5 * t70 + imu_T_camera4 * t71) +
        imu_T_camera7 * t73;
    const double t89 = t88 + imu_T_camera3 * t82 + imu_T_camera0 * t84 - imu_T_camera1 * t85 +
        imu_T_camera2 * t86;
    const double t90 = imu_T_camera6 * t70 - imu_T_camera7 * t71 + imu_T_camera5 * t72 -
        imu_T_camera4 * t73;
    const double t91 = t90 + imu_T_camera2 * t82 + imu_T_camera1 * t84 + imu_T_camera0 * t85 -
        imu_T_camera3 * t86;
    const double t92 = pose5 * t74 + pose4 * t75 - pose6 * t76 - pose7 * t77 + pose0 * t87 + pose3 *
        t89 + pose2 * t91;
    const double t93 = imu_T_camera7 * t70 + imu_T_camera6 * t71 + imu_T_camera4 * t72 +
        imu_T_camera5 * t73;
    const double t94 = t93 + imu_T_camera1 * t82 - imu_T_camera2 * t84 + imu_T_camera3 * t85 +
        imu_T_camera0 * t86;
    const double t95 = pose5 * t75 - pose4 * t74 - pose7 * t76 + pose6 * t77 + pose3 * t87 - pose0 *
        t89 - pose1 * t91;
    const double t96 = pose6 * t75 - pose7 * t74 + pose4 * t76 - pose5 * t77 - pose2 * t87 - pose1 *
        t89 + pose0 * t91;
    const double t97 = pose3 * t26 + pose0 * t28 - pose2 * t30 + pose1 * t32;
    const double t98 = pose1 * t26 + pose2 * t28 + pose0 * t30 - pose3 * t32;
    const double t99 = pose0 * t26 - pose3 * t28 - pose1 * t30 - pose2 * t32;
    const double t100 = pose2 * t26 - pose1 * t28 + pose3 * t30 + pose0 * t32;
    const double t101 = imu_T_camera5 * t97 - imu_T_camera7 * t98 + imu_T_camera4 * t99 -
        imu_T_camera6 * t100;
    const double t102 = pose4 * t26 + pose5 * t28 - pose7 * t30 - pose6 * t32 + pose0 * t46 + pose3
        * t51 + pose2 * t54;
    const double t103 = t102 - pose1 * t57;
    const double t104 = pose4 * t28 - pose5 * t26 - pose6 * t30 + pose7 * t32 - pose3 * t46 + pose0
        * t51 + pose1 * t54;
    const double t105 = t104 + pose2 * t57;
    const double t106 = pose6 * t26 - pose7 * t28 - pose5 * t30 + pose4 * t32 - pose2 * t46 - pose1
        * t51 + pose0 * t54;
    const double t107 = t106 - pose3 * t57;
    const double t108 = pose7 * t26 + pose6 * t28 + pose4 * t30 + pose5 * t32 + pose1 * t46 - pose2
        * t51 + pose3 * t54;
    const double t109 = t108 + pose0 * t57;
    const double t110 = t101 + imu_T_camera0 * t103 + imu_T_camera3 * t105 + imu_T_camera2 * t107 -
        imu_T_camera1 * t109;
    const double t111 = imu_T_camera6 * t98 - imu_T_camera4 * t97 + imu_T_camera5 * t99 -
        imu_T_camera7 * t100;
    const double t112 = t111 + imu_T_camera3 * t103 - imu_T_camera0 * t105 - imu_T_camera1 * t107 -
        imu_T_camera2 * t109;
    const double t113 = imu_T_camera6 * t99 - (imu_T_camera5 * t98 + imu_T_camera7 * t97) +
        imu_T_camera4 * t100;
    const double t114 = t113 - imu_T_camera2 * t103 - imu_T_camera1 * t105 + imu_T_camera0 * t107 -
        imu_T_camera3 * t109;
    const double t115 = imu_T_camera0 * t98 + imu_T_camera2 * t97 + imu_T_camera1 * t99 -
        imu_T_camera3 * t100;
    const double t116 = imu_T_camera3 * t98 - imu_T_camera1 * t97 + imu_T_camera2 * t99 +
        imu_T_camera0 * t100;
    const double t117 = imu_T_camera0 * t97 - imu_T_camera2 * t98 + imu_T_camera3 * t99 +
        imu_T_camera1 * t100;
    const double t118 = pose3 * t70 + pose0 * t71 - pose2 * t72 + pose1 * t73;
    const double t119 = pose1 * t70 + pose2 * t71 + pose0 * t72 - pose3 * t73;
    const double t120 = pose0 * t70 - pose3 * t71 - pose1 * t72 - pose2 * t73;
    const double t121 = pose2 * t70 - pose1 * t71 + pose3 * t72 + pose0 * t73;
    const double t122 = imu_T_camera5 * t118 - imu_T_camera7 * t119 + imu_T_camera4 * t120 -
        imu_T_camera6 * t121;
    const double t123 = pose4 * t70 + pose5 * t71 - pose7 * t72 - pose6 * t73 + pose0 * t82 + pose3
        * t84 + pose2 * t85;
    const double t124 = t123 - pose1 * t86;
    const double t125 = pose4 * t71 - pose5 * t70 - pose6 * t72 + pose7 * t73 - pose3 * t82 + pose0
        * t84 + pose1 * t85;
    const double t126 = t125 + pose2 * t86;
    const double t127 = pose6 * t70 - pose7 * t71 - pose5 * t72 + pose4 * t73 - pose2 * t82 - pose1
        * t84 + pose0 * t85;
    const double t128 = t127 - pose3 * t86;
    const double t129 = pose7 * t70 + pose6 * t71 + pose4 * t72 + pose5 * t73 + pose1 * t82 - pose2
        * t84 + pose3 * t85;
    const double t130 = t129 + pose0 * t86;
    const double t131 = t122 + imu_T_camera0 * t124 + imu_T_camera3 * t126 + imu_T_camera2 * t128 -
        imu_T_camera1 * t130;
    const double t132 = imu_T_camera6 * t119 - imu_T_camera4 * t118 + imu_T_camera5 * t120 -
        imu_T_camera7 * t121;
    const double t133 = t132 + imu_T_camera3 * t124 - imu_T_camera0 * t126 - imu_T_camera1 * t128 -
        imu_T_camera2 * t130;
    const double t134 = imu_T_camera6 * t120 - (imu_T_camera5 * t119 + imu_T_camera7 * t118) +
        imu_T_camera4 * t121;
    const double t135 = t134 - imu_T_camera2 * t124 - imu_T_camera1 * t126 + imu_T_camera0 * t128 -
        imu_T_camera3 * t130;
    const double t136 = imu_T_camera0 * t119 + imu_T_camera2 * t118 + imu_T_camera1 * t120 -
        imu_T_camera3 * t121;
    const double t137 = imu_T_camera3 * t119 - imu_T_camera1 * t118 + imu_T_camera2 * t120 +
        imu_T_camera0 * t121;
    const double t138 = imu_T_camera0 * t118 - imu_T_camera2 * t119 + imu_T_camera3 * t120 +
        imu_T_camera1 * t121;
    seen[0] = t19;
    seen[1] = t21;
    depth[0] = t17;
    pose_effect[0] = -0.5 * (t63 - pose1 * t65);
    pose_effect[1] = -0.5 * (t66 - pose2 * t65);
    pose_effect[2] = -0.5 * (t67 - pose3 * t65);
    pose_effect[3] = -0.5 * (pose2 * t33 + pose1 * t34 - pose3 * t35 + pose0 * t36);
    pose_effect[4] = -0.5 * (pose2 * t34 - pose1 * t33 + pose0 * t35 + pose3 * t36);
    pose_effect[5] = -0.5 * (pose0 * t33 + pose3 * t34 + pose1 * t35 - pose2 * t36);
    pose_effect[6] = -0.5 * (t92 - pose1 * t94);
    pose_effect[7] = -0.5 * (t95 - pose2 * t94);
    pose_effect[8] = -0.5 * (t96 - pose3 * t94);
    pose_effect[9] = -0.5 * (pose2 * t74 + pose1 * t75 - pose3 * t76 + pose0 * t77);
    pose_effect[10] = -0.5 * (pose2 * t75 - pose1 * t74 + pose0 * t76 + pose3 * t77);
    pose_effect[11] = -0.5 * (pose0 * t74 + pose3 * t75 + pose1 * t76 - pose2 * t77);
    extrinsics_effect[0] = -0.5 * t110;
    extrinsics_effect[1] = -0.5 * t112;
    extrinsics_effect[2] = -0.5 * t114;
    extrinsics_effect[3] = -0.5 * t115;
    extrinsics_effect[4] = -0.5 * t116;
    extrinsics_effect[5] = -0.5 * t117;
    extrinsics_effect[6] = -0.5 * t131;
    extrinsics_effect[7] = -0.5 * t133;
    extrinsics_effect[8] = -0.5 * t135;
    extrinsics_effect[9] = -0.5 * t136;
    extrinsics_effect[10] = -0.5 * t137;
    extrinsics_effect[11] = -0.5 * t138;
}
